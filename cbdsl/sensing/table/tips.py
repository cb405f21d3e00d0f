"""Tips: placements and Jacobians of the ends of the arms (Eq 3.11 to 3.13)."""

from __future__ import annotations

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics, Point
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.table.table import RowPart


class Tips:
    """Tips of effectors in the newest posture.

    Attributes:
        clock: Count of the postures, shape (1,).
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics) -> None:
        self._kinematics = kinematics
        self._tips = {
            name: (effector.tip.link, effector.tip.offset)
            for name, effector in robot.effectors.items()
            if effector.tip is not None
        }
        self.clock = np.zeros(1, dtype=np.int64)

    @property
    def stamp(self) -> int:
        """Number of the newest posture."""
        return int(self.clock[0])

    def point(self, effector: str) -> Point:
        """Return the control point of an effector."""
        return self._kinematics.point(*self._tips[effector])

    def frame(self, effector: str) -> Frame:
        """Return the frame of the link that carries an effector's tip."""
        return self._kinematics.frame(self._tips[effector][0])

    def normal(self, effector: str) -> Floats:
        """Return the +z axis of a tip, in which a palm faces, world frame, shape (3,)."""
        return self.frame(effector).rotation[:, 2]

    def part(self, effector: str) -> RowPart:
        """Return an effector's control point as a part of a row of the signal table."""
        name, offset = self._tips[effector]
        link = self._kinematics.link(name)
        return RowPart(link.frame, link.point(offset), link.rotation.ravel(), link.support)
