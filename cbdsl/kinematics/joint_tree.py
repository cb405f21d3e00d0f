"""Interpreted forward kinematics of a URDF model, for tools that place links once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from cbdsl.kinematics.pose import Pose, displacement
from cbdsl.robot.urdf import UrdfJoint


class PlacedJoint(NamedTuple):
    """Joint at a position.

    Attributes:
        joint: Joint of the model.
        frame: Frame of the joint at zero, in the root's.
        child: Frame of the link that it moves, in the root's.
    """

    joint: UrdfJoint
    frame: Pose
    child: Pose


class JointTree:
    """Joints that carry each other.

    Args:
        joints: Joints, each after its parent; links that none of them moves are roots.
    """

    def __init__(self, joints: Iterable[UrdfJoint]) -> None:
        self.joints = tuple(joints)
        self._origins = [Pose.at(joint.origin) for joint in self.joints]

    def place(self, positions: Mapping[str, float]) -> Mapping[str, PlacedJoint]:
        """Return all joints, by the links that they move.

        Args:
            positions: Positions of joints by name, rad or m; other joints are at zero.
        """
        placed: dict[str, PlacedJoint] = {}
        root = Pose(np.zeros(3), np.eye(3))
        for joint, origin in zip(self.joints, self._origins, strict=True):
            parent = placed.get(joint.parent)
            frame = (root if parent is None else parent.child) @ origin
            position = positions.get(joint.name, 0.0) if joint.movable else 0.0
            child = frame @ displacement(joint, position) if position else frame
            placed[joint.child] = PlacedJoint(joint, frame, child)
        return placed
