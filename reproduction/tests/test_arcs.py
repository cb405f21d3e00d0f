"""Arcs of diagrams, and the source's arcs that are among them."""

from __future__ import annotations

import pytest
from drawn_experience import experience
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_reproduction.chapter_4.arcs import ActionArc, DrawnArc, diagram_of

STEPS = st.tuples(*(st.sampled_from(each) for each in (["XX", "X0"], ["a", "b"], ["X0", "X1"])))


@given(st.lists(st.lists(STEPS, min_size=1, max_size=5), max_size=5))
def test_shares_of_arcs_from_a_state_sum_to_one(episodes: list[list[tuple[str, str, str]]]) -> None:
    experiences = [experience(*steps) for steps in episodes]
    whole = diagram_of(experiences, least=0.0)
    for state in {arc.state for arc in whole}:
        assert sum(share for arc, share in whole.items() if arc.state == state) == pytest.approx(1)
    drawn = diagram_of(experiences)
    assert drawn == {arc: share for arc, share in whole.items() if share > 0.2}


def test_arcs_that_are_rare_are_not_drawn() -> None:
    often, seldom = ("XX", "track", "X0"), ("XX", "track", "X-")
    assert diagram_of([experience(often)] * 4 + [experience(seldom)]) == {ActionArc(*often): 0.8}


@pytest.mark.parametrize(
    ("arc", "among", "joined"),
    [
        (ActionArc("X-", "search", "0X"), True, True),
        (ActionArc("1-", "search", "1X"), True, True),
        (ActionArc("X-", "track", "0X"), False, True),
        (ActionArc("X0", "search", "0X"), False, False),
        (ActionArc("X-", "search", "X-"), False, False),
    ],
)
def test_drawn_arc_is_found_by_patterns(arc: ActionArc, among: bool, joined: bool) -> None:
    drawn = DrawnArc("*-", "search", ("0X", "1*"))
    assert (drawn.is_among([arc]), drawn.is_joined([arc])) == (among, joined)


@pytest.mark.parametrize("action", ["search ◁ track", "track ◁ search", "search", "search ◁ reach"])
def test_is_among_compares_the_order_of_a_composition_on_request(action: str) -> None:
    drawn, arc = DrawnArc("XX", "search ◁ track", ("00",)), ActionArc("XX", action, "00")
    assert drawn.is_among([arc]) == (action == drawn.action)
    assert drawn.is_turned_among([arc]) == (sorted(action.split()) == sorted(drawn.action.split()))
    assert not drawn.is_turned_among([arc._replace(next_state="0-")])
