"""Objects that are placed, slip through hands, or are held by two arms: each by its evidence."""

from __future__ import annotations

import numpy as np
import pytest
from made_history import TICKS, course, flags, made, predicates, pressed, transition

from cbdsl.runtime.recording import SIGHT
from cbdsl_why.diagnosis import diagnose
from cbdsl_why.history import FailureCause, History
from cbdsl_why.placing_causes import placings

_TICK = np.arange(TICKS)
_PLAIN = {"potential": "spring", "reference": "", "base": "", "requires": ""}
_ORIENT = {**_PLAIN, "feedback": "right.orientation", "unit": "rad", "effector": "right.position"}


def _first(history: History) -> FailureCause:
    cause = diagnose(history).cause
    assert cause is not None
    return cause


def _kinds(history: History) -> list[str]:
    diagnosis = diagnose(history)
    first = [] if diagnosis.cause is None else [diagnosis.cause]
    return [each.kind for each in (*first, *diagnosis.others)]


def _pair(turn: float, height: float, acts: int) -> History:
    """Return a miss of two palms, of which the right one is turned, around an object."""
    palm = '<link name="{0}"/><joint name="{0}_at" type="fixed"><parent link="base"/>'
    palm += '<child link="{0}"/><origin xyz="0.5 {1} 0" rpy="{2} 0 0"/></joint></robot>'
    urdf = made().summary["robot"]["urdf"]
    for name, y, angle in (("left", 0.3, 90.0), ("right", -0.3, turn - 90.0)):
        urdf = urdf.replace("</robot>", palm.format(name, y, np.radians(angle)))
    tip = {"joint": "shoulder", "offset": [0, 0, 0]}
    tips = {name: {**tip, "link": name} for name in ("left", "right")}
    robot = {**made().summary["robot"], "urdf": urdf, "tips": tips}
    robot["cells"] = {"hand.thumb": "left", "hand.finger": "right"}
    triples = made().summary["triples"]
    grip = {"feedback": "hands.net_forces", "effector": "arms.position"}
    arms = {"feedback": "arms.centroid", "effector": "arms.centroid"}
    facts = {"type": "orientation", "place": False, "channels": []}
    levels = np.tile([0, -1, acts], (TICKS, 1))
    levels[60:, 0] = -1
    return made(
        predicates=predicates(("0XX", 60), ("X-X", 60)),
        flags=flags("seeking", 1, slice(60, 90)) | flags("exhausted", 1, slice(90, TICKS)),
        level_priority=levels,
        robot=robot,
        triples={
            "reach": {**triples["reach"], **arms},
            "hold": {**triples["hold"], **grip},
            "posture": _ORIENT,
        },
        signals={**made().summary["signals"], "right.orientation": facts},
        errors=course(0.0, 2, slice(None), 0.1),
        signal_stereo__red=np.tile([0.5, 0.0, height], (TICKS, 1)),
        signal_right__orientation=np.tile(np.eye(3), (TICKS, 1, 1)),
    )


@pytest.mark.parametrize(
    ("turn", "height", "acts", "kind"),
    [
        (0.0, 0.3, 1, "translation"),
        (90.0, 0.0, 1, "rotation"),
        (90.0, 0.0, -1, "no_rotation"),
        (0.0, 0.0, 1, "no_grasp"),
    ],
)
def test_miss_of_two_arms_is_named_by_the_line_between_their_palms(
    turn: float, height: float, acts: int, kind: str
) -> None:
    assert kind in _kinds(_pair(turn, height, acts))


def test_two_arms_hold_by_the_net_forces_of_their_hands() -> None:
    history = _pair(0.0, 0.0, 1)
    assert [each.name for each in history.courses if each.grasps] == ["hold"]
    assert history.hands == ("arms",)
    assert history.pair("arms") == ("left", "right")


def test_failed_drive_is_dated_by_the_rise_of_its_lag() -> None:
    # The reference leaves the joint from the 40th tick on, and is half a lead away in the 52nd.
    references = np.zeros((TICKS, 2))
    references[:, 1] = np.clip(_TICK - 40, 0, 30) * 0.005
    cause = _first(made(references=references))
    assert cause.kind == "not_followed"
    assert abs(cause.tick - 42) <= 3


def _placed(error: float, axis: str = "0 0 1") -> History:
    """Return a hand that moves an object, and lets go before a camera compares it with its goal.

    Args:
        error: Distance from the goal, m.
        axis: Axis of the shoulder; a level one tilts the object.
    """
    positions = np.zeros((TICKS, 2))
    positions[:, 0] = np.clip(_TICK - 30, 0, 20) * 0.02
    triples = made().summary["triples"]
    there = {**_PLAIN, "feedback": "red.to.green", "unit": "m", "effector": "head"}
    offset = {"type": "offset", "place": False, "channels": ["red", "green"]}
    letters = "1" if error < 0.05 else "0"
    robot = made().summary["robot"]
    turned = robot["urdf"].replace('<axis xyz="0 0 1"/>', f'<axis xyz="{axis}"/>', 1)
    return made(
        robot={**robot, "urdf": turned},
        predicates=predicates(("X1X", 60), (f"XX{letters}", 60)),
        positions=positions,
        references=positions,
        triples={**triples, "posture": there},
        leads={"reach": "reach", "hold": "hold", "posture": "there"},
        signals={**made().summary["signals"], "red.to.green": offset},
        signal_red__to__green=np.zeros((TICKS, 3)),
        errors=course(error, 2, slice(None), 0.0),
        loads=pressed(2.0, 0.0, slice(0, 60))["loads"],
    )


def test_object_that_was_measured_beside_its_goal_is_a_translation() -> None:
    found = [(each.kind, each.tick) for each in placings(_placed(0.2))]
    assert found == [("translation", 59)]
    assert not list(placings(_placed(0.02)))


def test_object_that_its_hand_had_tilted_is_a_rotation() -> None:
    (found,) = placings(_placed(0.2, axis="0 1 0"))
    # The shoulder turned by 20 steps of 0.02 rad while the hand held the object.
    assert (found.kind, found.tick) == ("rotation", 59)
    assert found.numbers["angle"] == pytest.approx(0.4)


@pytest.mark.parametrize(("beside", "is_beside"), [(0.1, True), (0.03, False)])
@pytest.mark.parametrize("is_seen", [True, False])
def test_object_that_is_seen_beside_its_goal_at_the_end_is_a_translation(
    beside: float, is_beside: bool, is_seen: bool
) -> None:
    positions = np.zeros((TICKS, 2))
    positions[:, 0] = np.clip(_TICK - 30, 0, 20) * 0.02
    triples = made().summary["triples"]
    goal = {"type": "position", "place": True, "channels": ["green"]}
    kind = "seen" if is_seen else "unseen"
    history = made(
        predicates=predicates(("01X", 60), ("XXX", 60)),
        positions=positions,
        references=positions,
        channels=["red", "green"],
        sight=np.full((TICKS, 2), [SIGHT.index(kind), SIGHT.index("seen")]),
        triples={**triples, "reach": {**triples["reach"], "base": "stereo.green"}}
        | {"posture": {**triples["reach"], "feedback": "stereo.red", "base": "stereo.green"}},
        signals={**made().summary["signals"], "stereo.green": goal},
        signal_stereo__red=np.tile([0.8, 0.1 + beside, 0.3], (TICKS, 1)),
        signal_stereo__green=np.tile([0.8, 0.1, 0.0], (TICKS, 1)),
        loads=pressed(2.0, 0.0, slice(0, 60))["loads"],
    )
    found = [(each.kind, each.tick, round(each.numbers["beside"], 6)) for each in placings(history)]
    assert found == ([("translation", 59, beside)] if is_beside and is_seen else [])


def test_object_under_a_condition_that_was_never_seen_is_named() -> None:
    history = made(
        members={"pick": ["reach", "wide"]},
        leads={"reach": "reach"},
        transitions=[transition("XX", "look", "X-", 1.0, 1)],
        sight=np.full((TICKS, 1), SIGHT.index("unseen")),
        signal_stereo__red=np.full((TICKS, 3), np.nan),
    )
    assert "never_seen" in _kinds(history)


@pytest.mark.parametrize("stirred", [0.03, 0.0])
def test_object_left_behind_by_a_lifted_hand_has_slipped(stirred: float) -> None:
    places = np.tile([0.9, 0.04, 0.0], (TICKS, 1))
    places[50:, 2] = stirred
    positions = np.zeros((TICKS, 2))
    positions[:, 0] = np.clip(_TICK - 30, 0, 20) * -0.02
    robot = made().summary["robot"]
    turned = robot["urdf"].replace('<axis xyz="0 0 1"/>', '<axis xyz="0 1 0"/>', 1)
    levels = np.tile([0, -1, 1], (TICKS, 1))
    levels[20:, :2] = [-1, 0]
    history = made(
        predicates=predicates(("0XX", 20), ("X1X", 100)),
        level_priority=levels,
        positions=positions,
        references=positions,
        robot={**robot, "urdf": turned},
        signal_stereo__red=places,
        loads=pressed(2.0, 0.0, slice(20, TICKS))["loads"],
    )
    assert ("slip" in _kinds(history)) == (stirred > 0.02)
