"""Stereo triangulation (Eq 3.14): two lines of sight meet in a position."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Ray(NamedTuple):
    """A line of sight in the world frame.

    Attributes:
        origin: the camera's optical centre, m, shape (3,).
        direction: unit vector, shape (3,).
    """

    origin: Floats
    direction: Floats


class Crossing(NamedTuple):
    """Where two lines of sight come nearest to each other.

    Attributes:
        position: the middle between the nearest points, m, shape (3,).
        gap: the distance between the nearest points, m.
    """

    position: Floats
    gap: float


def triangulate(left: Ray, right: Ray) -> Crossing | None:
    """Cross two lines of sight; ``None`` where they are parallel or cross behind a camera."""
    between = right.origin - left.origin
    cosine = float(left.direction.dot(right.direction))
    determinant = 1.0 - cosine * cosine
    if determinant < 1e-9:
        return None
    along_left, along_right = (float(between.dot(ray.direction)) for ray in (left, right))
    left_range = (along_left - cosine * along_right) / determinant
    right_range = (cosine * along_left - along_right) / determinant
    if left_range <= 0 or right_range <= 0:
        return None
    left_point = left.origin + left_range * left.direction
    right_point = right.origin + right_range * right.direction
    return Crossing((left_point + right_point) / 2, math.dist(left_point, right_point))
