"""Distances of seen objects from the bases of effectors."""

from __future__ import annotations

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.vision.signals.visual_signals import VisualSignals
from cbdsl.types.resource import ObjectDistance, StereoPosition


class Distances:
    """Reader of distances between objects and the first joints of effectors.

    The reach of an arm is about a ball around its first joint. A limit of reach is therefore one
    threshold of this distance, but a staircase of thresholds of the coordinates.

    Args:
        robot: Robot document with effectors and groups.
        kinematics: Kinematics of the same robot.
        sight: Visual signals with the positions of objects.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics, sight: VisualSignals) -> None:
        self._robot, self._kinematics, self._sight = robot, kinematics, sight

    def read(self, source: ObjectDistance) -> Reading | None:
        """Return the distance, m, from the nearest base; ``None`` without a position."""
        seen = self._sight.position(StereoPosition(source.channel, source.instance), ())
        if seen is None:
            return None
        bases = self._kinematics.origins(self._first_joints(source.effector), ())
        distances = np.linalg.norm(bases - seen.value, axis=1)
        return Reading(distances.min(keepdims=True), None, seen.stamp)

    def _first_joints(self, effector: str) -> tuple[str, ...]:
        """Return the joint of each member that moves all its other joints."""
        moving = {
            member: {joint: len(self._kinematics.above(joint)) for joint in joints}
            for member in self._robot.members(effector)
            if (joints := self._robot.joints(member))
        }
        return tuple(min(above, key=above.__getitem__) for above in moving.values())
