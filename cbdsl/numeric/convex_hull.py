"""Convex hulls of points, with few corners."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull

from cbdsl.numeric.arrays import Floats, Rows

# Number of a hull's corners beyond which contacts cost more without becoming better.
_MOST = 128


def hull_corners(points: Floats) -> Floats:
    """Return the corners of the convex hull of points that span a volume, m, shape (k, 3).

    Hulls with too many corners keep the farthest corners in evenly spread directions and along the
    axes.

    Args:
        points: Points, m, shape (n, 3).
    """
    corners: Floats = points[ConvexHull(points).vertices]
    if len(corners) <= _MOST:
        return corners
    directions = np.vstack((np.eye(3), -np.eye(3), _spread(_MOST - 6)))
    kept = np.unique(np.argmax(directions @ corners.T, axis=1))
    few: Floats = corners[kept]
    return few


def hull_faces(corners: Floats) -> Rows:
    """Return the corners' indices of a hull's triangles, shape (n, 3), in no particular order."""
    return np.asarray(ConvexHull(corners).simplices, dtype=np.intp)


def _spread(count: int) -> Floats:
    """Return evenly spread directions on a spiral from pole to pole, shape (count, 3)."""
    steps = np.arange(count) + 0.5
    heights, angles = 1 - 2 * steps / count, math.pi * (1 + math.sqrt(5)) * steps
    across = np.sqrt(1 - heights**2)
    return np.column_stack((across * np.cos(angles), across * np.sin(angles), heights))
