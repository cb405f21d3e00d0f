"""Tips: where the ends of the arms are, and how the joints move them (Eq 3.11 to 3.13)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.kinematics import Kinematics, Point
from cbdsl.sensing.reading import Reading, mean, stacked, transform
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
        self._tips = {
            name: (effector.tip.link, effector.tip.offset)
            for name, effector in robot.effectors.items()
            if effector.tip is not None
        }
        self.stamp = 0

    def read(self, source: TipSource) -> Reading:
        """An effector's tip, or the positions of all of a group's."""
        if source.effector in self._tips:
            return self.tip(source, 0.0)
        return stacked([self.position(member) for member in self._robot.members(source.effector)])

    def centroid(self, source: Centroid) -> Reading:
        """The mean of a group's tip positions; x_avg of Eq 3.41."""
        return mean([self.position(member) for member in self._robot.members(source.group)])

    def separation(self, source: Separation) -> Reading:
        """The second tip of a group relative to its first."""
        first, second = (self.position(member) for member in self._robot.members(source.group))
        return Reading(second.value - first.value, second.jacobian - first.jacobian, self.stamp)

    def position(self, effector: str) -> Reading:
        """The position of one effector's tip."""
        point = self._point(effector, 0.0)
        return Reading(point.position, point.jacobian[:3], self.stamp)

    def normal(self, effector: str) -> Floats:
        """The +z axis of a tip, the direction in which a palm faces, world frame, shape (3,)."""
        return self._kinematics.frame(self._link(effector)).rotation[:, 2]

    def tip(self, source: TipSource, standoff: float) -> Reading:
        """A tip's reading, with its control point ``standoff`` metres along the tip's +z axis."""
        if source.part == "position":
            point = self._point(source.effector, standoff)
            return Reading(point.position, point.jacobian[:3], self.stamp)
        link = self._link(source.effector)
        rotation = self._kinematics.frame(link).rotation
        if source.part == "orientation":
            return Reading(rotation, self._kinematics.turning(link), self.stamp)
        point = self._point(source.effector, standoff)
        return Reading(transform(rotation, point.position), point.jacobian, self.stamp)

    def manipulator(self, effector: str, part: str) -> Reading:
        """The manipulator Jacobian of an effector's tip, with its curvature (Eq 3.5).

        Args:
            effector: an effector with a tip, or a group, whose members' Jacobians are stacked.
            part: ``position`` for three rows a tip, ``pose`` for six.
        """
        if effector in self._tips:
            return self._manipulator(effector, part)
        tips = [self._manipulator(member, part) for member in self._robot.members(effector)]
        return Reading(
            np.concatenate([tip.value for tip in tips]),
            np.concatenate([tip.jacobian for tip in tips]),
            self.stamp,
            curvature=np.concatenate([tip.curvature for tip in tips]),
        )

    def _manipulator(self, effector: str, part: str) -> Reading:
        rows = 3 if part == "position" else 6
        position, jacobian = self._point(effector, 0.0)
        curvature = self._kinematics.curvature(self._link(effector), position, rows)
        return Reading(position, jacobian[:rows], self.stamp, curvature=curvature)

    def _point(self, effector: str, standoff: float) -> Point:
        """The control point of an effector."""
        link, (x, y, z) = self._tips[effector]
        return self._kinematics.point(link, (x, y, z + standoff))

    def _link(self, effector: str) -> str:
        return self._tips[effector][0]
