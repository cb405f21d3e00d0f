"""Poses of recorded links, with quaternions as (x, y, z, w)."""

from __future__ import annotations

import numpy as np

from cbdsl.kinematics.quaternion import product, quaternion_about, turned
from cbdsl.numeric.arrays import Floats
from cbdsl.reporting.drawn_links import DrawnLink


def placed(link: DrawnLink, positions: Floats) -> tuple[Floats, Floats]:
    """Return the position and the quaternion of a link in the frame of its parent.

    Args:
        link: The link.
        positions: Recorded joint positions, rad or m, shape (n,).
    """
    angle = link.offset + (link.ratio * positions[link.column] if link.column >= 0 else 0.0)
    place, turn = np.array(link.position, dtype=float), np.array(link.quaternion, dtype=float)
    # URDF allows axes of any length. A zero axis stays zero instead of NaN.
    axis = np.array(link.axis, dtype=float)
    axis /= np.linalg.norm(axis) or 1.0
    # The motion of the joint follows its constant origin. Its axis is therefore in the turned
    # frame.
    if link.motion == "slide":
        return place + turned(turn, axis * angle), turn
    if link.motion == "turn":
        return place, product(turn, quaternion_about(axis, angle))
    return place, turn
