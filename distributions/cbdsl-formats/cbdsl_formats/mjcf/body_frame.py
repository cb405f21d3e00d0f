"""Frames of bodies, relative to the bodies that carry them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import Floats


class BodyFrame(NamedTuple):
    """Position, m, shape (3,), and rotation matrix, shape (3, 3), in another frame."""

    position: Floats
    rotation: Floats

    def then(self, other: BodyFrame) -> BodyFrame:
        """Return a frame that is given in this one, in the parent of this one."""
        return BodyFrame(
            self.position + self.rotation @ other.position, self.rotation @ other.rotation
        )


def moved(position: Iterable[float]) -> BodyFrame:
    """Return a translated frame, m."""
    return BodyFrame(np.array(position, dtype=np.float64), np.eye(3))


def placed(position: Floats, quaternion: Floats) -> BodyFrame:
    """Return a frame that is translated, m, and turned by a quaternion (w, x, y, z)."""
    rotation = np.zeros(9)
    mj.mju_quat2Mat(rotation, np.asarray(quaternion, dtype=np.float64))
    return BodyFrame(np.array(position, dtype=np.float64), rotation.reshape(3, 3))


def turned(axis: Floats, angle: float) -> BodyFrame:
    """Return a frame that is turned about an axis, rad."""
    quaternion = np.zeros(4)
    mj.mju_axisAngle2Quat(quaternion, np.asarray(axis, dtype=np.float64), angle)
    return placed(np.zeros(3), quaternion)
