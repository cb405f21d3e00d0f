"""Poses of recorded links, with quaternions as (x, y, z, w)."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.reporting.model import DrawnLink


def placed(link: DrawnLink, positions: Floats) -> tuple[Floats, Floats]:
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


def product(first: Floats, second: Floats) -> Floats:
    """Return the product of two quaternions, the rotation by ``second`` followed by ``first``."""
    vector = first[3] * second[:3] + second[3] * first[:3] + np.cross(first[:3], second[:3])
    return np.array([*vector, first[3] * second[3] - first[:3] @ second[:3]])


def inverse(turn: Floats) -> Floats:
    """Return the inverse of a unit quaternion."""
    conjugate: Floats = turn * np.array([-1.0, -1.0, -1.0, 1.0])
    return conjugate


def turned(turn: Floats, vector: Floats) -> Floats:
    """Return a vector, shape (3,), rotated by a unit quaternion."""
    twice = 2.0 * np.cross(turn[:3], vector)
    result: Floats = vector + turn[3] * twice + np.cross(turn[:3], twice)
    return result
