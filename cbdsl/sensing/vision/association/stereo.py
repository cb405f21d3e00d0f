"""Stereo triangulation of a position from two lines of sight (Eq 3.14)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once


class Ray(NamedTuple):
    """Line of sight in the world frame.

    Attributes:
        origin: Optical centre of the camera, m, shape (3,).
        direction: Direction of the line, shape (3,).
        length: Length of the direction.
    """

    origin: Floats
    direction: Floats
    length: float = 1.0


class Crossing(NamedTuple):
    """Point at which two lines of sight come nearest to each other.

    Attributes:
        position: Middle between the nearest points, m, shape (3,).
        gap: Distance between the nearest points, m.
    """

    position: Floats
    gap: float


def triangulate(left: Ray, right: Ray) -> Crossing | None:
    """Cross two lines of sight; return ``None`` if they are parallel or cross behind a camera."""
    position = np.empty(3)
    gap = cross_rays(*left, *right, position)
    return None if math.isnan(gap) else Crossing(position, gap)


@compiled_once
def cross_rays(
    left: Floats,
    left_direction: Floats,
    left_length: float,
    right: Floats,
    right_direction: Floats,
    right_length: float,
    position: Floats,
) -> float:
    """Write the position of a crossing; return its gap, m, or NaN without a crossing."""
    cosine = along_left = along_right = 0.0
    for i in range(3):
        left_unit, right_unit = left_direction[i] / left_length, right_direction[i] / right_length
        cosine += left_unit * right_unit
        along_left += (right[i] - left[i]) * left_unit
        along_right += (right[i] - left[i]) * right_unit
    determinant = 1.0 - cosine * cosine
    if determinant < 1e-9:
        return math.nan
    left_range = (along_left - cosine * along_right) / determinant
    right_range = (cosine * along_left - along_right) / determinant
    if left_range <= 0.0 or right_range <= 0.0:
        return math.nan
    square = 0.0
    for i in range(3):
        left_point = left[i] + left_range * (left_direction[i] / left_length)
        right_point = right[i] + right_range * (right_direction[i] / right_length)
        position[i] = (left_point + right_point) / 2.0
        square += (left_point - right_point) ** 2
    return math.sqrt(square)
