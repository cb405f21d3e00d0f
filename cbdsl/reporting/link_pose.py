"""Poses of recorded links, with quaternions as (x, y, z, w)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.reporting.model import DrawnLink

Doubles = NDArray[np.float64]


def placed(link: DrawnLink, positions: Doubles) -> tuple[Doubles, Doubles]:
    """Return the position and the quaternion of a link in the frame of its parent.

    Args:
        link: The link.
        positions: Recorded joint positions, rad or m, shape (n,).
    """
    angle = link.offset + (link.ratio * positions[link.column] if link.column >= 0 else 0.0)
    place, turn = np.array(link.position, dtype=float), np.array(link.quaternion, dtype=float)
    axis = np.array(link.axis, dtype=float)
    axis /= np.linalg.norm(axis) or 1.0
    if link.motion == "slide":
        return place + turned(turn, axis * angle), turn
    if link.motion == "turn":
        return place, product(turn, np.array([*(math.sin(angle / 2) * axis), math.cos(angle / 2)]))
    return place, turn


def product(first: Doubles, second: Doubles) -> Doubles:
    """Return the product of two quaternions, the rotation by ``second`` followed by ``first``."""
    vector = first[3] * second[:3] + second[3] * first[:3] + np.cross(first[:3], second[:3])
    return np.array([*vector, first[3] * second[3] - first[:3] @ second[:3]])


def inverse(turn: Doubles) -> Doubles:
    """Return the inverse of a unit quaternion."""
    conjugate: Doubles = turn * np.array([-1.0, -1.0, -1.0, 1.0])
    return conjugate


def turned(turn: Doubles, vector: Doubles) -> Doubles:
    """Return a vector, shape (3,), rotated by a unit quaternion."""
    twice = 2.0 * np.cross(turn[:3], vector)
    result: Doubles = vector + turn[3] * twice + np.cross(turn[:3], twice)
    return result
