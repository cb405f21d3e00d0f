"""Transition diagrams, which show the observed transitions of a greedy policy."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest
from drawn_experience import experience
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.learning.experience import Experience
from cbdsl_reproduction.chapter_4.arcs import ActionArc, diagram_of
from cbdsl_reproduction.diagram import Diagram, graph_of
from tests.conftest import Checked

# Actions of a greedy policy: one for each state.
CHOSEN = {"XX": "search", "X0": "search ◁ track", "X-": "track"}
STATES = st.sampled_from(list(CHOSEN))


def walked(states: list[str], rewarded: bool) -> Experience:
    """Return an episode from XX through the states to X1, which ends it."""
    passed = zip(["XX", *states], [*states, "X1"], strict=True)
    return experience(*((a, CHOSEN[a], b) for a, b in passed), reward=int(rewarded))


@given(st.lists(st.tuples(st.lists(STATES, max_size=4), st.booleans()), min_size=1, max_size=6))
def test_arc_has_its_share_of_the_transitions_from_its_state(
    checked: Checked, episodes: list[tuple[list[str], bool]]
) -> None:
    experiences = [walked(*episode) for episode in episodes]
    graph = graph_of("some", checked("searchtrack"), experiences)
    expected = diagram_of(experiences)
    drawn = {ActionArc(a.source, CHOSEN[a.source], a.target): a.share for a in graph.arcs}
    # States that no drawn arc reaches are left out of the picture.
    assert drawn.keys() <= expected.keys()
    assert drawn == pytest.approx({arc: expected[arc] for arc in drawn})
    assert "XX" in {decision.state for decision in graph.decisions}
    always = all(reward for _, reward in episodes)
    assert graph.rewarded == ({"X1"} if always else set())


def test_picture_is_that_of_the_policy(checked: Checked) -> None:
    graph = graph_of("some_7", checked("searchtrack"), [walked(["X-", "X0"], rewarded=True)])
    diagram = Diagram("fig", "a < b", graph)
    told = " ".join(ET.fromstring(diagram.svg()).itertext())
    assert all(action in told for action in CHOSEN.values())
    assert diagram.data() == {
        "arcs": [
            ["XX", "search", "X-", 1.0],
            ["X-", "track", "X0", 1.0],
            ["X0", "search ◁ track", "X1", 1.0],
        ]
    }
