"""Pictures of policies: the episodes that they show, and the arcs that match the source's."""

from __future__ import annotations

import pytest
from drawn_experience import experience

from cbdsl_reproduction.chapter_4.arcs import DrawnArc
from cbdsl_reproduction.chapter_4.checks import Check
from cbdsl_reproduction.chapter_4.transition_diagrams import (
    DrawnPolicy,
    _quantities,
    _typical,
    orders_alike,
)
from cbdsl_reproduction.series import REACHTOUCH
from tests.conftest import Checked

FOUND = [("XXX", "reach ◁ touch", "X0-"), ("X0-", "reach ◁ touch", "X11")]
CIRCLE = [("XXX", "reach ◁ touch", "X1-"), *[("X1-", "searchtrack", "X1-")] * 90]


@pytest.mark.parametrize(
    ("contexts", "shown"), [(("presented", "absent"), "X11"), (("absent",), "X1-")]
)
def test_picture_omits_unrewarded_contexts_unless_all_are(
    checked: Checked, contexts: tuple[str, ...], shown: str
) -> None:
    held_out = tuple(
        experience(*(CIRCLE if name == "absent" else FOUND), context=name) for name in contexts
    )
    diagram = _typical("fig", REACHTOUCH, checked("reachtouch"), [Check(25, held_out)])
    targets = {arc.target for arc in diagram.graph.arcs}
    assert shown in targets
    assert ("X1-" in targets) == (shown == "X1-")


REACH, TURNED = "reach ◁ touch", "touch ◁ reach"
ARC = DrawnArc("X0*", REACH, ("X11",))


@pytest.mark.parametrize(
    ("worth", "alike"),
    [
        ({"X0-": {REACH: 90.0, TURNED: 86.0}}, True),
        ({"X0-": {REACH: 90.0, TURNED: 85.0}}, False),
        ({"X0-": {REACH: 60.0, TURNED: 100.0}}, True),
        ({"X0-": {REACH: 90.0, TURNED: 90.0}, "X00": {REACH: 90.0, TURNED: 50.0}}, False),
        ({"X0-": {REACH: 90.0, TURNED: 90.0}, "X1-": {REACH: 90.0, TURNED: 50.0}}, True),
        ({"X0-": {REACH: 90.0}}, False),
        ({}, False),
    ],
)
def test_orders_of_a_composition_with_equal_values_are_equivalent(
    worth: dict[str, dict[str, float]], alike: bool
) -> None:
    assert orders_alike(ARC, worth) == alike


def test_single_action_has_no_equivalent_order() -> None:
    assert not orders_alike(DrawnArc("X0-", "reach", ("X1-",)), {"X0-": {"reach": 100.0}})


def test_arc_of_a_context_that_did_not_occur_is_not_required() -> None:
    arcs = (DrawnArc("X0-", REACH, ("X11",)), DrawnArc("X0-", REACH, ("X1-",), "absent"))
    drawn = DrawnPolicy("", REACHTOUCH, arcs)
    absent = experience(("XXX", "searchtrack", "X0-"), ("X0-", "touch", "X11"), context="absent")
    for episodes, counts in (((IN_ORDER,), "1 of 1"), ((IN_ORDER, absent), "0 of 1")):
        whole, *_ = _quantities(drawn, [Check(25, episodes)], {})
        assert whole.note == f"{counts} trials"


IN_ORDER = experience(("XXX", "searchtrack", "X0-"), ("X0-", REACH, "X11"))
OTHER_ORDER = experience(("XXX", "searchtrack", "X0-"), ("X0-", TURNED, "X11"))
DIFFERENT = experience(("XXX", "searchtrack", "X0-"), ("X0-", "touch", "X11"))
PAST_IT = experience(("XXX", "searchtrack", "1XX"), ("1XX", "reach", "X11"))


@pytest.mark.parametrize(
    ("worth", "counts"), [({}, "1 of 3 trials"), ({"X0-": {REACH: 99.0, TURNED: 99.0}}, "2 of 3")]
)
def test_arc_is_judged_by_the_trials_that_leave_its_state(
    worth: dict[str, dict[str, float]], counts: str
) -> None:
    last = [Check(25, (each,)) for each in (IN_ORDER, OTHER_ORDER, DIFFERENT, PAST_IT)]
    drawn = DrawnPolicy("", REACHTOUCH, (DrawnArc("XXX", "searchtrack", ("X0-",)), ARC))
    whole, first, arc = _quantities(drawn, last, worth)
    assert arc.note.startswith(counts)
    assert ("1 in the order drawn" in arc.note) == bool(worth)
    assert "3 with any action" in arc.note
    assert whole.note == f"{counts[0]} of 4 trials"
    assert first.note.startswith("3 of 4 trials")
