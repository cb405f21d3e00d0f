"""Poses: rotations and translations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfOrigin

_X, _Y, _Z = np.eye(3)


def rotations(quaternions: Floats) -> Floats:
    """Return matrices, shape (..., 3, 3), of unit quaternions (x, y, z, w), shape (..., 4)."""
    single = quaternions.ndim == 1
    # Plain numbers take a tenth of the time for a single quaternion.
    x, y, z, w = quaternions.tolist() if single else np.moveaxis(quaternions, -1, 0)
    entries = (
        *(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        *(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        *(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    if single:
        return np.array(entries).reshape(3, 3)
    return np.stack(entries, axis=-1).reshape(*quaternions.shape[:-1], 3, 3)


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
        quaternion = np.append(np.sin(angle / 2) * axis, np.cos(angle / 2))
        return cls(np.zeros(3), rotations(quaternion))

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
        m = self.rotation
        # Of the four formulas, the one with the largest divisor is numerically safe.
        divisors = np.array([1 + np.trace(m), *(1 - np.trace(m) + 2 * np.diag(m))])
        case = int(np.argmax(divisors))
        root = 2 * np.sqrt(divisors[case])
        skew = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
        if case == 0:
            x, y, z = skew / root
            return float(x), float(y), float(z), float(root / 4)
        axis = case - 1
        vector = (m[axis] + m[:, axis]) / root
        vector[axis] = root / 4
        x, y, z = vector
        return float(x), float(y), float(z), float(skew[axis] / root)
