"""Hands that an object stops, that press on others, or close too early: each by its evidence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from made_history import TICKS, flags, made, predicates, pressed, transition

from cbdsl_why.diagnosis import diagnose
from cbdsl_why.history import History
from cbdsl_why.premises import doubts

_TICK = np.arange(TICKS)
_PLAIN = {"potential": "spring", "reference": "", "base": "", "requires": ""}
_ORIENT = {**_PLAIN, "feedback": "arm.orientation", "unit": "rad", "effector": "arm.orientation"}
_TURNS = np.tile(np.eye(3), (TICKS, 1, 1))
# Both joints of the arm push from the 20th tick on, at an object between the fingers.
_URDF = (
    made()
    .summary["robot"]["urdf"]
    .replace('<parent link="lower"/>', '<parent link="knuckle"/>')
    .replace(
        '<link name="pad"/>',
        '<link name="knuckle"/><joint name="grip" type="revolute"><parent link="lower"/>'
        '<child link="knuckle"/><axis xyz="0 0 1"/>'
        '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint><link name="pad"/>',
    )
)
_PUSHED = np.where(_TICK[:, None] < 20, 0.0, [0.12, 0.12, 0.0])
_STOPPED: Mapping[str, Any] = {
    "robot": {**made().summary["robot"], "urdf": _URDF},
    "joints": ["shoulder", "elbow", "grip"],
    "positions": np.zeros((TICKS, 3)),
    "at_limits": np.zeros((TICKS, 3), dtype=bool),
    "references": _PUSHED,
    "signal_stereo__red": np.tile([0.98, 0.04, 0.0], (TICKS, 1)),
    "errors": np.full((TICKS, 3), 0.05),
    "signal_arm__orientation": _TURNS,
}
# One finger presses sideways while the hand closes, the other one feels nothing.
_LOADS = np.zeros((TICKS, 2, 6))
_LOADS[30:, 1, 1] = 4.0
_SIDED: Mapping[str, Any] = {
    "predicates": predicates(("0XX", 20), ("X-X", 100)),
    "flags": flags("seeking", 1, slice(20, 115)) | flags("exhausted", 1, slice(115, TICKS)),
    "level_priority": np.where(_TICK[:, None] < 20, [0, -1, 1], [-1, 0, 1]),
    "loads": _LOADS,
    "references": np.where(_TICK[:, None] < 30, 0.0, [0.0, 0.02]),
}


def _tilted(turn: float) -> str:
    """Return a URDF whose tip is turned about its x axis, deg."""
    urdf: str = made().summary["robot"]["urdf"]
    origin = f'<origin xyz="0.5 0 0" rpy="{np.radians(turn)} 0 0"/></joint>\n  <joint name="side"'
    return urdf.replace('<origin xyz="0.5 0 0"/></joint>\n  <joint name="side"', origin)


def _named(history: History) -> tuple[str, int]:
    cause = diagnose(history).cause
    return ("", -1) if cause is None else (cause.kind, cause.tick)


def _oriented(base: str = "", **reach: Any) -> dict[str, Any]:
    """Return triples with an orientation in the place of the posture, and changes of the reach."""
    triples = made().summary["triples"]
    orient = {**_ORIENT, "reference": "3, 0, 0", "base": base}
    return {**triples, "posture": orient, "reach": {**triples["reach"], **reach}}


def _signals() -> dict[str, Any]:
    facts = {"type": "orientation", "place": False, "channels": []}
    return {**made().summary["signals"], "arm.orientation": facts}


@pytest.mark.parametrize(
    ("acts", "beside", "force", "kind"),
    [
        (1, 0.0, 0.0, "rotation"),
        (-1, 0.0, 0.0, "no_rotation"),
        (1, 0.1, 0.0, "translation"),
        (1, 0.0, 0.8, "wrong_object"),
    ],
    ids=["turned", "never turned", "beside", "on its fingers"],
)
def test_hand_that_an_object_stops_is_named_by_its_geometry(
    acts: int, beside: float, force: float, kind: str
) -> None:
    changes = {
        **_STOPPED,
        "signal_stereo__red": _STOPPED["signal_stereo__red"] + [0.0, beside, 0.0],
        "level_priority": np.tile([0, -1, acts], (TICKS, 1)),
        "loads": pressed(force, 0.0, slice(20, TICKS))["loads"],
    }
    errors = np.where(np.arange(3) == 2, 0.0, 0.05) * np.ones((TICKS, 1))
    history = made(**{**changes, "errors": errors}, triples=_oriented(), signals=_signals())
    named = _named(history)
    assert named[0] == kind
    assert abs(named[1] - 20) <= 4


@pytest.mark.parametrize("lag", [0.0, 0.02, 0.05])
def test_hand_is_stopped_only_while_its_joints_push(lag: float) -> None:
    history = made(**{**_STOPPED, "references": lag / 0.12 * _PUSHED})
    assert not history.pushes("hand").any()
    assert made(**_STOPPED).pushes("hand")[40:].all()


def test_hand_far_from_objects_is_not_stopped_by_them() -> None:
    history = made(**{**_STOPPED, "signal_stereo__red": np.tile([3.0, 0.0, 0.0], (TICKS, 1))})
    assert not history.near.any()
    assert not history.pushes("hand").any()


@pytest.mark.parametrize(
    ("place", "speed", "is_other"),
    [(0.02, 0.0, True), (0.04, 0.0, False), (0.02, 0.1, False)],
    ids=["beside it", "on it", "moves it"],
)
def test_press_that_does_not_move_the_object_is_on_another_one(
    place: float, speed: float, is_other: bool
) -> None:
    moved = np.outer(speed * np.clip(_TICK - 30, 0, None) / 60, [0.0, 1.0, 0.0])
    facts = {**_SIDED, "signal_stereo__red": np.array([1.0, place, 0.0]) + moved}
    assert (_named(made(**facts))[0] == "no_rotation") == is_other
    turned = {"triples": _oriented(), "signals": _signals(), "signal_arm__orientation": _TURNS}
    errors = np.where(np.arange(3) == 2, 0.0, 0.1) * np.ones((TICKS, 1))
    history = made(**facts, **turned, errors=errors)
    assert (_named(history)[0] == "wrong_object") == is_other


def test_object_that_stands_a_force_between_the_fingers_is_a_doubt() -> None:
    loads = np.where(_TICK[:, None, None] < 1, 0.0, _LOADS[-1])
    seeking = flags("seeking", 1, slice(0, TICKS))
    changes = {
        **_SIDED,
        "loads": loads,
        "flags": seeking,
        "predicates": ["X-X"] * TICKS,
        "time": _TICK / 40,
        "references": np.tile([0.0, 0.02], (TICKS, 1)),
        "level_priority": np.tile([0, 0, 1], (TICKS, 1)),
    }
    for place, found in ((0.04, True), (0.0, False)):
        history = made(**{**changes, "signal_stereo__red": np.tile([1, place, 0], (TICKS, 1))})
        assert any("it is heavy, or fixed" in each.clause for each in doubts(history)) == found


def test_hand_that_closes_before_the_last_approach_of_its_program_is_in_wrong_order() -> None:
    triples = made().summary["triples"]
    behind = {**triples["reach"], "feedback": "hand.centre"}
    miss = {
        "predicates": predicates(("0XX", 60), ("X-X", 60)),
        "flags": flags("seeking", 1, slice(60, 90)) | flags("exhausted", 1, slice(90, TICKS)),
        "level_priority": np.where(_TICK[:, None] < 60, [0, -1, -1], [-1, 0, -1]),
        "signal_stereo__red": np.tile([0.8, 0.0, 0.0], (TICKS, 1)),
    }
    assert _named(made(**miss))[0] == "translation"
    history = made(**miss, triples={**triples, "posture": behind})
    assert _named(history) == ("wrong_order", 60)
    assert "before posture had moved the hand" in getattr(diagnose(history).cause, "sentence", "")


@pytest.mark.parametrize(("behind", "kind"), [("hand.centre", "wrong_order"), ("", "slip")])
def test_hand_that_lost_an_object_had_closed_too_early_if_an_approach_was_left(
    behind: str, kind: str
) -> None:
    triples = made().summary["triples"]
    later = {**triples["reach"], "feedback": behind} if behind else triples["posture"]
    history = made(
        predicates=predicates(("0XX", 20), ("X1X", 60), ("X-X", 40)),
        level_priority=np.where(
            _TICK[:, None] < 20, [0, -1, -1], np.where(_TICK[:, None] < 80, [-1, 0, -1], [-1, 0, 1])
        ),
        triples={**triples, "posture": later},
        **pressed(2.0, 0.02, slice(20, 80)),
    )
    assert _named(history) == (kind, 80)


def test_hand_that_single_fingers_hold_by_has_only_these_fingers() -> None:
    triples = made().summary["triples"]
    assert made().fingers("hand", 0) == pytest.approx(np.array([[1, 0, 0], [1, 0.08, 0]]))
    hold = {**triples["hold"], "feedback": "hand.finger.force"}
    history = made(triples={**triples, "hold": hold})
    assert history.fingers("hand", 0) == pytest.approx(np.array([[1, 0.08, 0]]))
    assert (made().spread("hand", 0), history.spread("hand", 0)) == pytest.approx((0.04, 0.0))


@pytest.mark.parametrize(("rests", "kind"), [("0", "no_grasp"), ("1", "slip")])
def test_contact_that_ends_before_any_hold_is_no_grasp(rests: str, kind: str) -> None:
    history = made(
        predicates=predicates(("X0X", 40), (f"X{rests}X", 30), ("X-X", 50)),
        level_priority=np.tile([-1, 0, 1], (TICKS, 1)),
        **{**pressed(2.0, 0.02, slice(0, 70)), "time": _TICK / 30},
    )
    assert _named(history) == (kind, 70)


@pytest.mark.parametrize(("turn", "kind"), [(45, "no_rotation"), (5, "no_grasp"), (85, "no_grasp")])
def test_oblique_hand_that_no_controller_turns_has_no_rotation(turn: float, kind: str) -> None:
    robot = {**made().summary["robot"], "urdf": _tilted(turn)}
    history = made(
        robot=robot,
        predicates=predicates(("0XX", 60), ("X-X", 60)),
        flags=flags("seeking", 1, slice(60, 90)) | flags("exhausted", 1, slice(90, TICKS)),
        signal_stereo__red=np.tile([1.0, 0.02, 0.0], (TICKS, 1)),
    )
    assert _named(history)[0] == kind


def test_hand_whose_action_ended_while_it_closed_has_closed_on_nothing() -> None:
    history = made(
        predicates=predicates(("0XX", 20), ("X-X", 100)),
        flags=flags("seeking", 1, slice(20, TICKS)),
        transitions=[transition("X-X", "hold", "X-X", 1.9, 100)],
        signal_stereo__red=np.tile([1.0, 0.02, 0.0], (TICKS, 1)),
    )
    assert _named(history)[0] == "no_grasp"


def test_level_that_waits_where_it_is_has_no_cause() -> None:
    held = np.full((TICKS, 3), -1)
    held[:, 0] = 2
    triples = made().summary["triples"]
    waits = {**triples, "reach": {**triples["posture"], "reference": "here"}}
    changes = {"level_share": np.zeros((TICKS, 3)), "level_held_by": held}
    assert _named(made(**changes, triples=waits))[0] != "held"


def test_approach_that_an_orientation_holds_is_a_rotation() -> None:
    held = np.full((TICKS, 3), -1)
    held[:, 0] = 2
    changes = {
        "level_share": 0.0 * np.ones((TICKS, 3)),
        "level_held_by": held,
        "signal_arm__orientation": _TURNS,
    }
    assert _named(made(**changes))[0] == "held"
    history = made(**changes, triples=_oriented(), signals=_signals())
    assert _named(history)[0] == "rotation"
    kept = {**_oriented(), "posture": {**_ORIENT, "reference": "here"}}
    assert _named(made(**changes, triples=kept, signals=_signals()))[0] == "held"


@pytest.mark.parametrize(("place", "is_other"), [(0.5, True), (0.9, False)])
def test_object_that_an_arm_moves_by_another_grasp_is_the_wrong_one(
    place: float, is_other: bool
) -> None:
    triples = made().summary["triples"]
    history = made(
        predicates=predicates(("X0X", 30), ("X1X", 90)),
        triples={**triples, "posture": {**triples["reach"], "feedback": "stereo.red"}},
        level_priority=np.tile([-1, 0, 1], (TICKS, 1)),
        signal_stereo__red=np.tile([place, 0.0, 0.0], (TICKS, 1)),
    )
    assert (_named(history) == ("wrong_object", 30)) == is_other


@pytest.mark.parametrize("seed", range(5))
def test_fingers_are_where_plane_geometry_puts_them(seed: int) -> None:
    positions = np.random.default_rng(seed).uniform(-3.0, 3.0, (TICKS, 2))
    history = made(positions=positions)
    for tick in (0, 40, TICKS - 1):
        first, both = positions[tick, 0], positions[tick].sum()
        along, across = np.array([[np.cos(both), np.sin(both)], [-np.sin(both), np.cos(both)]])
        elbow = 0.5 * np.array([np.cos(first), np.sin(first)])
        tips = [elbow + 0.5 * along, elbow + 0.5 * along + 0.08 * across]
        np.testing.assert_allclose(history.fingers("hand", tick)[:, :2], tips, atol=1e-9)


def test_acting_controllers_are_those_of_the_time_before_a_tick() -> None:
    levels = np.where(_TICK[:, None] < 60, [0, -1, -1], [-1, 0, -1])
    history = made(level_priority=levels)
    assert history.acting(50, 0.5) == {"reach"}
    assert history.acting(75, 0.5) == {"reach", "hold"}
    assert history.acting(TICKS - 1, 0.5) == {"hold"}


def test_known_place_of_an_object_is_the_last_seen_one() -> None:
    places = np.tile([0.8, 0.1, 0.0], (TICKS, 1))
    places[:10], places[50:] = np.nan, np.nan
    known = made(signal_stereo__red=places).known("stereo.red")
    assert np.isnan(known[:10]).all()
    np.testing.assert_allclose(known[10:], np.tile([0.8, 0.1, 0.0], (TICKS - 10, 1)))
