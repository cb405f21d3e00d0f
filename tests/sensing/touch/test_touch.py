"""Which motion closes a hand, and when the hands of a group hold something."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.table.tips import Tips
from cbdsl.sensing.touch.touch import Touch
from cbdsl.types.resource import NetLoad
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

Make = Callable[..., Touch]


@pytest.fixture(scope="module")
def touch_of(library: Library) -> Make:
    def make(name: str, **contact: float) -> Touch:
        robot = library.read(library.locate(RobotDocument, name), RobotDocument).document
        changed = robot.contact.model_copy(update=contact)
        robot = robot.model_copy(update={"contact": changed})
        kinematics = Kinematics(robot, ROOT / "robots" / robot.model)
        return Touch(robot, kinematics, Tips(robot, kinematics))

    return make


def feel(touch: Touch, *cells: int) -> None:
    """Have some load cells feel 1 N, after a tick without contact."""
    touch.reset()
    wrenches = np.zeros_like(touch.loads)
    touch.update(wrenches.copy(), 0.0)
    wrenches[list(cells), 0] = 1.0
    touch.update(wrenches, 0.0)


def test_fingers_close_in_the_direction_in_which_they_press(touch_of: Make) -> None:
    assert touch_of("dexter").closing == {"left_hand": 1.0, "right_hand": 1.0}
    assert touch_of("panda").closing == {"hand": -1.0}  # its joint opens as it grows


def test_group_holds_an_object_that_all_its_hands_touch(touch_of: Make) -> None:
    touch = touch_of("dexter")
    feel(touch, 0, 1)
    assert not touch.all_holding("hands")
    feel(touch, 0, 3)
    assert touch.all_holding("hands")


def test_single_hand_holds_an_object_that_it_touches(touch_of: Make) -> None:
    touch = touch_of("dexter", self_contact=5.0)
    feel(touch, 0)
    assert not touch.all_holding("right_hand")
    assert touch.all_holding("left_hand")


def test_hands_that_touch_each_other_hold_nothing(touch_of: Make) -> None:
    touch = touch_of("dexter", self_contact=5.0)
    feel(touch, 0, 3)
    assert not touch.all_holding("hands")


@pytest.mark.parametrize(("robot", "hand"), [("dexter", "right_hand"), ("panda", "hand")])
def test_net_torque_has_the_moments_of_the_fingers_forces(
    touch_of: Make, robot: str, hand: str
) -> None:
    """Compare virtual work: a turn about the tip does equal work on the fingers and the sum."""
    rng = np.random.default_rng(1)
    touch = touch_of(robot)
    touch.reset()
    touch.update(np.zeros_like(touch.loads), 0.0)
    touch.update(rng.normal(size=touch.loads.shape), 0.0)
    document, kinematics = touch._robot, touch._kinematics
    cells, (first, last) = document.load_cells[hand], touch.span(hand)
    tip = document.effectors[touch.carriers[hand]].tip
    assert tip is not None
    places = [kinematics.frame(cell.link).position for cell in cells.values()]
    palm = kinematics.frame(tip.link)
    pivot = palm.position + palm.rotation @ np.array(tip.offset)
    wrench = touch.net_load(NetLoad(hand, "wrench"))
    assert wrench is not None
    for turn in np.eye(3):
        ways = [np.cross(turn, place - pivot) for place in places]
        work = sum(
            float(load[:3] @ way + load[3:] @ turn)
            for load, way in zip(touch.loads[first:last], ways, strict=True)
        )
        assert float(wrench.value[3:] @ turn) == pytest.approx(work, abs=1e-12)
    np.testing.assert_allclose(wrench.value[:3], touch.loads[first:last, :3].sum(axis=0))
    torque = touch.net_load(NetLoad(hand, "torque"))
    assert torque is not None
    np.testing.assert_array_equal(torque.value, wrench.value[3:])
    assert torque.jacobian is not None
    assert wrench.jacobian is not None
    np.testing.assert_array_equal(torque.jacobian, wrench.jacobian[3:])


def test_net_wrench_of_a_couple_is_a_torque_alone(touch_of: Make) -> None:
    """Turn an object with two fingers that press against each other side by side."""
    touch = touch_of("dexter")
    touch.reset()
    wrenches = np.zeros_like(touch.loads)
    touch.update(wrenches.copy(), 0.0)
    first = touch.span("right_hand")[0]
    wrenches[first, 1], wrenches[first + 2, 1] = 2.0, -2.0
    touch.update(wrenches, 0.0)
    cells = list(touch._robot.load_cells["right_hand"].values())
    one, other = (touch._kinematics.frame(cells[i].link).position for i in (0, 2))
    wrench = touch.net_load(NetLoad("right_hand", "wrench"))
    assert wrench is not None
    couple = np.cross(one - other, [0.0, 2.0, 0.0])
    assert np.linalg.norm(couple) > 0.01
    np.testing.assert_allclose(wrench.value, [0, 0, 0, *couple], atol=1e-12)


def test_net_torque_grows_as_the_hand_turns_on(touch_of: Make) -> None:
    """Cast tips as springs, whose forces have moments about the hand's tip."""
    touch = touch_of("dexter")
    feel(touch, 3, 4, 5)
    torque = touch.net_load(NetLoad("right_hand", "torque"))
    assert torque is not None
    assert torque.jacobian is not None
    control, kinematics = touch._robot.control, touch._kinematics
    tip = touch._robot.effectors["right_arm"].tip
    assert tip is not None
    pivot = kinematics.point(tip.link, tip.offset).position
    expected = np.zeros((3, len(kinematics.joints)))
    for cell in touch._robot.load_cells["right_hand"].values():
        rows = kinematics.jacobian(cell.link)
        lever = kinematics.frame(cell.link).position - pivot
        for joint, (way, turn) in enumerate(zip(rows[:3].T, rows[3:].T, strict=True)):
            expected[:, joint] += control.contact_torsion * turn
            expected[:, joint] += np.cross(lever, control.contact_stiffness * way)
    np.testing.assert_allclose(torque.jacobian, expected, atol=1e-9)


@pytest.mark.parametrize("held", [True, False])
def test_load_cells_are_tared_again_only_without_contact(touch_of: Make, held: bool) -> None:
    before = touch_of("dexter")
    feel(before, *([0] if held else []))
    drifted = np.full_like(before.loads, 0.05)
    touch = touch_of("dexter")
    touch.reset()
    touch.resume(before)
    wrenches = drifted + (1.0 if held else 0.0)
    touch.update(wrenches, 0.0)
    # Contact with a held object remains; without one, the present reading becomes the zero.
    assert touch.loads == pytest.approx(wrenches if held else np.zeros_like(drifted))
    assert touch.feeling.any() == held


def test_without_a_tip_torques_are_about_the_middle_of_the_cells(touch_of: Make) -> None:
    touch = touch_of("dexter")
    touch.carriers = {}
    feel(touch)
    first, last = touch.span("left_hand")
    cells = list(touch._robot.load_cells["left_hand"].values())
    places = np.array([touch._kinematics.frame(cell.link).position for cell in cells])
    forces = np.zeros_like(touch.loads)
    forces[first:last, :3] = np.random.default_rng(2).normal(size=(3, 3))
    touch.update(forces, 0.0)
    wrench = touch.net_load(NetLoad("left_hand", "wrench"))
    assert wrench is not None
    torques = np.cross(places - places.mean(axis=0), forces[first:last, :3])
    np.testing.assert_allclose(wrench.value[3:], torques.sum(axis=0), atol=1e-12)


def test_contact_is_cleared_at_reset(touch_of: Make) -> None:
    touch = touch_of("dexter")
    feel(touch, 0, 3)
    assert touch.touching_anything() and touch.loads.any() and touch.feeling.any()
    touch.reset()
    assert not touch.touching_anything()
    assert not touch.loads.any() and not touch.feeling.any()
