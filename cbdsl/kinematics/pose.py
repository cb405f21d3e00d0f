"""Poses: rotations and translations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbdsl.kinematics.quaternion import quaternion_about, quaternion_of, rotations
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfJoint, UrdfOrigin

_X, _Y, _Z = np.eye(3)


@dataclass(frozen=True)
class Pose:
    """Frame in the world.

    Attributes:
        position: Position of its origin, m, shape (3,).
        rotation: Axes as columns, shape (3, 3).
    """

    position: Floats
    rotation: Floats

    @classmethod
    def of(cls, position: Sequence[float], quaternion: Sequence[float]) -> Pose:
        """Return a pose in the simulator's notation, with quaternions as (x, y, z, w)."""
        return cls(np.array(position), rotations(np.array(quaternion)))

    @classmethod
    def turned(cls, axis: Floats, angle: float) -> Pose:
        """Return a rotation at the origin about a unit ``axis``, shape (3,), by ``angle``, rad."""
        return cls(np.zeros(3), rotations(quaternion_about(axis, angle)))

    @classmethod
    def at(cls, origin: UrdfOrigin) -> Pose:
        """Return a pose in a URDF's notation."""
        roll, pitch, yaw = origin.rpy
        turned = cls.turned(_Z, yaw) @ cls.turned(_Y, pitch) @ cls.turned(_X, roll)
        return cls(np.array(origin.xyz), turned.rotation)

    def __matmul__(self, inner: Pose) -> Pose:
        """Return the frame ``inner``, given in this one, in the world."""
        return Pose(self.position + self.rotation @ inner.position, self.rotation @ inner.rotation)

    def quaternion(self) -> tuple[float, float, float, float]:
        """Return the rotation as (x, y, z, w)."""
        return quaternion_of(self.rotation)


def axis_of(joint: UrdfJoint) -> Floats:
    """Return the axis of a joint's motion in its own frame, of unit length, shape (3,).

    The axis of a fixed joint means nothing, and is 0 in some models; it stays 0.
    """
    axis = np.array(joint.axis)
    unit: Floats = axis / (np.linalg.norm(axis) or 1.0)
    return unit


def displacement(joint: UrdfJoint, position: float) -> Pose:
    """Return the pose of a joint's child, relative to that at zero.

    Args:
        joint: Joint that turns, slides, or is fixed.
        position: Position of the joint, rad or m.
    """
    if joint.slides:
        return Pose(position * axis_of(joint), np.eye(3))
    return Pose.turned(axis_of(joint), position)
