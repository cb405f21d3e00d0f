"""Which motion closes a hand, and when the hands of a group hold something."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.tips import Tips
from cbdsl.sensing.touch import Touch
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
    touch.update(wrenches.copy())
    wrenches[list(cells), 0] = 1.0
    touch.update(wrenches)


def test_fingers_close_in_the_direction_in_which_they_press(touch_of: Make) -> None:
    assert touch_of("dexter").closing == {"left_hand": 1.0, "right_hand": 1.0}
    assert touch_of("panda").closing == {"hand": -1.0}  # its joint opens as it grows


def test_hands_hold_what_each_of_them_touches(touch_of: Make) -> None:
    touch = touch_of("dexter")
    feel(touch, 0, 1)
    assert not touch.all_holding("hands")
    feel(touch, 0, 3)
    assert touch.all_holding("hands")


def test_a_hand_alone_holds_what_it_touches(touch_of: Make) -> None:
    touch = touch_of("dexter", self_contact=5.0)
    feel(touch, 0)
    assert not touch.all_holding("right_hand")
    assert touch.all_holding("left_hand")


def test_hands_that_touch_each_other_hold_nothing(touch_of: Make) -> None:
    touch = touch_of("dexter", self_contact=5.0)
    feel(touch, 0, 3)
    assert not touch.all_holding("hands")
