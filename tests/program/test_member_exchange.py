"""A program in the place of a member keeps the member's predicate, and its reward."""

from __future__ import annotations

from cbdsl.program.member_exchange import (
    earned_signals,
    exchange,
    member_places,
    signals_at_its_end,
)
from tests.conftest import Checked


def test_exchange_of_a_member_keeps_its_compositions(checked: Checked) -> None:
    probing = exchange(checked("reachtouch"), "touch", checked("tactileprobe"))
    actions = {each.name: each for each in probing.actions}
    alone, below, above = (actions[name] for name in ("touch", "touch ◁ reach", "reach ◁ touch"))
    assert alone.composition is None and alone.part == "touch"
    for each in (below, above):
        assert each.composition is not None and each.part == "touch"
        assert [part.name for part in each.composition.primitives] == ["reach"]
    # The last one has priority.
    assert (below.above, above.above) == (3, 0)
    assert actions["reach"] == {a.name: a for a in checked("reachtouch").actions}["reach"]
    assert probing.members == ("searchtrack", "reach", "touch")


def test_signals_at_the_end_are_those_of_the_last_action(checked: Checked) -> None:
    handover, lifted = checked("handover"), checked("pick_and_lift")
    assert {each.signal for each in signals_at_its_end(handover)} == {"right_hand.finger_forces"}
    assert earned_signals(lifted) and not signals_at_its_end(lifted)
    assert signals_at_its_end(checked("reachtouch")) == earned_signals(checked("reachtouch"))


def test_member_places_of_a_controller_are_empty(checked: Checked) -> None:
    assert member_places(checked("reachtouch"), "touch") == frozenset()
    assert member_places(checked("pick_and_place"), "reachtouch") == {"stereo.red"}
