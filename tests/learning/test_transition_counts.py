"""Counts of transitions."""

from __future__ import annotations

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from cbdsl.learning.accommodate import TransitionCounts

STATES = st.sampled_from(["XX", "X0", "X1"])
STEPS = st.lists(st.tuples(STATES, st.sampled_from(["search", "track"]), STATES))


@given(STEPS)
def test_every_transition_counts_once(steps: list[tuple[str, str, str]]) -> None:
    counts = TransitionCounts()
    for step in steps:
        counts.add(*step)
    found = {
        (state, action, after): number
        for state, actions in counts.items()
        for action, reached in actions.items()
        for after, number in reached.items()
    }
    assert found == dict(Counter(steps))
