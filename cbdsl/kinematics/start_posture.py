"""Start posture: positions of all joints, and of tips, at the start of an episode."""

from __future__ import annotations

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats


def start_positions(robot: RobotDocument, kinematics: Kinematics) -> Floats:
    """Return the positions of all joints at the start of an episode, rad or m, shape (n,).

    Args:
        robot: Robot document.
        kinematics: Kinematics of the same robot.
    """
    positions = np.minimum(np.maximum(0.0, kinematics.lower), kinematics.upper)
    for name, posture in robot.start_postures.items():
        positions[kinematics.joints.of(name)] = posture
    return positions


def start_place(robot: RobotDocument, kinematics: Kinematics, effector: str) -> Floats:
    """Return the place of an effector's tip at the start of an episode, m, world frame, (3,).

    Args:
        robot: Robot document.
        kinematics: Kinematics of the same robot.
        effector: Name of an effector with a tip.
    """
    tip = robot.effectors[effector].tip
    assert tip is not None
    start = start_positions(robot, kinematics)
    return kinematics.posed(start, lambda: kinematics.point(tip.link, tip.offset).position)
