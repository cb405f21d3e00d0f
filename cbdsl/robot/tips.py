"""Tips: where the ends of the arms are, and how the joints move them (Eq 3.11 to 3.13)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.kinematics import Kinematics
from cbdsl.robot.reading import Reading, stacked, transform
from cbdsl.types.resource import Centroid, Separation
from cbdsl.types.resource import Tip as TipSource

Floats = NDArray[np.float64]


class Tips:
    """Reads the tips of effectors and groups from the kinematics of the newest posture.

    Attributes:
        stamp: of the newest posture.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics) -> None:
        self._robot = robot
        self._kinematics = kinematics
        self.stamp = 0

    def read(self, source: TipSource) -> Reading:
        """An effector's tip, or the positions of all of a group's."""
        members = self._robot.members(source.effector)
        if len(members) == 1:
            return self.tip(source, 0.0)
        return stacked([self.position(member) for member in members])

    def centroid(self, source: Centroid) -> Reading:
        """The mean of a group's tip positions; x_avg of Eq 3.41."""
        return self.mean([self.position(member) for member in self._robot.members(source.group)])

    def separation(self, source: Separation) -> Reading:
        """The second tip of a group relative to its first."""
        first, second = (self.position(member) for member in self._robot.members(source.group))
        return Reading(second.value - first.value, second.jacobian - first.jacobian, self.stamp)

    def position(self, effector: str) -> Reading:
        """The position of one effector's tip."""
        return self.tip(TipSource(effector, "position"), 0.0)

    def mean(self, tips: list[Reading]) -> Reading:
        """The mean of positions."""
        value = np.mean([tip.value for tip in tips], axis=0)
        return Reading(value, np.mean([tip.jacobian for tip in tips], axis=0), self.stamp)

    def normal(self, effector: str) -> Floats:
        """The +z axis of a tip, the direction in which a palm faces, world frame, shape (3,)."""
        tip = self._robot.effectors[effector].tip
        assert tip is not None
        return self._kinematics.frame(tip.link).rotation[:, 2]

    def tip(self, source: TipSource, standoff: float) -> Reading:
        """A tip's reading, with its control point ``standoff`` metres along the tip's +z axis."""
        tip = self._robot.effectors[source.effector].tip
        assert tip is not None
        kinematics = self._kinematics
        frame, jacobian = kinematics.frame(tip.link), kinematics.jacobian(tip.link)
        if source.part == "orientation":
            return Reading(frame.rotation, jacobian[3:], self.stamp)
        x, y, z = tip.offset
        lever = frame.rotation.dot((x, y, z + standoff))
        # The control point moves by v + omega x lever.
        linear = jacobian[:3] - _cross_matrix(lever).dot(jacobian[3:])
        position = frame.position + lever
        if source.part == "pose":
            pose = transform(frame.rotation, position)
            return Reading(pose, np.vstack((linear, jacobian[3:])), self.stamp)
        return Reading(position, linear, self.stamp)

    def manipulator(self, effector: str, part: str) -> Reading:
        """The manipulator Jacobian of an effector's tip, with its curvature (Eq 3.5).

        Args:
            effector: an effector with a tip, or a group, whose members' Jacobians are stacked.
            part: ``position`` for three rows a tip, ``pose`` for six.
        """
        rows = 3 if part == "position" else 6
        tips = [self.tip(TipSource(name, part), 0.0) for name in self._robot.members(effector)]
        return Reading(
            np.concatenate([tip.value[:3, 3] if rows == 6 else tip.value for tip in tips]),
            np.concatenate([tip.jacobian for tip in tips]),
            self.stamp,
            curvature=np.concatenate(
                [self._curvature(name)[:rows] for name in self._robot.members(effector)]
            ),
        )

    def _curvature(self, effector: str) -> Floats:
        tip = self._robot.effectors[effector].tip
        assert tip is not None
        lever = self._kinematics.frame(tip.link).rotation.dot(tip.offset)
        return self._kinematics.curvature(tip.link, lever)


def _cross_matrix(v: Floats) -> Floats:
    """The matrix that takes the cross product with ``v`` from the left."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
