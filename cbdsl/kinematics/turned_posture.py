"""Turned postures: a hand has turned a held object nearly all the way before the cameras."""

# Model: while the last joint of an arm goes from one end of its range to the other, a held object
# turns about the joint's axis u. Each side around u passes the line of sight s if u is across it,
# u . s = 0. If u is along s, the same side stays in view. The posture therefore maximizes
#     log m(q) - a mean((u . s)^2) - b unseen(p) - c low(p) - d way(q)
# where m is the manipulability of the tip's position p, ``unseen`` the angle outside of the
# cameras' views, ``low`` the height below the start, where the arm is clear of its surroundings,
# and ``way`` the distance of the joints from their start. All joints keep off the outer tenth of
# their ranges, but the last one: it is at the end of its range that is farther from its start.

from __future__ import annotations

import math

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.coordinate_ascent import ascend
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats

# Candidates of a joint, and the parts of its range at both ends that are left out.
_CANDIDATES = 24
_OUTER = 0.1
# Range of joints without limits, rad: a turn is never farther than half of one.
_HALF = math.pi
# Part of its range that the last joint keeps off its end.
_END = 0.02
_SWEEPS = 8
# Costs a, b, c and d in logarithms of manipulability: of a squared cosine; of squared angles,
# rad^2; of a squared height, in parts of the tip's first distance from the cameras; and of squared
# ways, in parts of half of the joints' ranges.
_ALONG = 100.0
_UNSEEN = 100.0
_LOW = 20.0
_WAY = 0.7
# Damping in parts of the squared distance from the cameras; see ``ready_posture``.
_DAMPING = 1e-4
# Part of a camera's half field of view that counts as in view.
_INNER = 0.7


class TurnedPosture:
    """Search for the turned posture of an arm, from the robot's model and cameras alone.

    The other effectors, such as a head with the cameras, are at their start postures.

    Args:
        robot: Document of the robot, with at least one camera.
        kinematics: Kinematics of the same robot.
        effector: Name of an effector with a tip.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics, effector: str) -> None:
        self._robot, self._kinematics = robot, kinematics
        tip = robot.effectors[effector].tip
        assert tip is not None
        self._tip = tip
        self._own = kinematics.joints.of(effector)
        self._postures = tuple(robot.effectors[effector].postures.values())
        self._start = start_positions(robot, kinematics)
        start = self._start[self._own]
        lower, upper = kinematics.lower[self._own], kinematics.upper[self._own]
        self._lower = np.where(np.isfinite(lower), lower, start - _HALF)
        self._upper = np.where(np.isfinite(upper), upper, start + _HALF)
        self._scale, self._height = kinematics.posed(self._start, self._start_place)

    def find(self) -> Floats:
        """Return the positions of the effector's joints, rad or m, shape (n,)."""
        choices = [*(self._candidates(joint) for joint in range(len(self._own) - 1)), ()]
        climbed = [ascend(first, choices, self._score, _SWEEPS) for first in self._firsts()]
        return np.array(max(climbed, key=lambda each: each[1])[0])

    def _firsts(self) -> list[tuple[float, ...]]:
        """Return the postures from which the search begins: the start, and all declared ones."""
        declared = [tuple(self._start[self._own].tolist()), *self._postures]
        return [(*posture[:-1], self._end()) for posture in declared]

    def _end(self) -> float:
        """Return the end of the last joint's range that is farther from its start, rad or m."""
        start, lower, upper = self._start[self._own[-1]], self._lower[-1], self._upper[-1]
        margin = _END * (upper - lower)
        return float(upper - margin if upper - start >= start - lower else lower + margin)

    def _candidates(self, joint: int) -> list[float]:
        lower, upper = self._lower[joint], self._upper[joint]
        margin = _OUTER * (upper - lower)
        positions: list[float] = np.linspace(lower + margin, upper - margin, _CANDIDATES).tolist()
        return positions

    def _score(self, own: tuple[float, ...]) -> float:
        posture = self._start.copy()
        posture[self._own] = own
        return self._kinematics.posed(posture, lambda: self._score_here(posture[self._own]))

    def _score_here(self, own: Floats) -> float:
        kinematics = self._kinematics
        jacobian = kinematics.point(self._tip.link, self._tip.offset)
        # Angular velocity per velocity of the last joint: its axis.
        axis = jacobian.jacobian[3:, self._own[-1]]
        lines = [jacobian.position - frame.position for frame in self._cameras()]
        across = [float(axis @ line / np.linalg.norm(line)) for line in lines]
        linear = jacobian.jacobian[:3, self._own] / self._scale
        square = linear @ linear.T + _DAMPING * np.eye(3)
        half = (self._upper - self._lower) / 2
        way = (own - self._start[self._own])[:-1] / half[:-1]
        return (
            float(np.linalg.slogdet(square)[1]) / 2
            - _ALONG * sum(each**2 for each in across) / len(across)
            - _UNSEEN * self._unseen(jacobian.position)
            - _LOW * max(0.0, self._height - float(jacobian.position[2])) ** 2 / self._scale**2
            - _WAY * float(way @ way)
        )

    def _start_place(self) -> tuple[float, float]:
        """Return the mean distance of the tip from the cameras, and its height, m."""
        tip = self._kinematics.point(self._tip.link, self._tip.offset).position
        far = [np.linalg.norm(tip - camera.position) for camera in self._cameras()]
        return float(np.mean(far)), float(tip[2])

    def _cameras(self) -> list[Frame]:
        links = tuple(camera.link for camera in self._robot.main_cameras.values())
        return self._kinematics.placed(links)

    def _unseen(self, point: Floats) -> float:
        """Return the sum of squared angles, rad^2, by which a point is outside of the views."""
        total = 0.0
        for camera, frame in zip(self._robot.main_cameras.values(), self._cameras(), strict=True):
            # Cameras look along x, with y to the left and z up.
            x, y, z = frame.rotation.T @ (point - frame.position)
            for side, size in ((y, camera.width), (z, camera.height)):
                half = _INNER * math.atan2(size / 2, camera.focal_length)
                total += max(0.0, abs(math.atan2(side, x)) - half) ** 2
        return total


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
