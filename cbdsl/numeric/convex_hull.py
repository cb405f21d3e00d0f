"""Convex hulls of points, with few corners."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

Floats = NDArray[np.float64]
Faces = NDArray[np.intp]

# Corners of a hull, beyond which contacts cost more than they are better.
_MOST = 128


def hull_corners(points: Floats) -> Floats:
    """Corners of the convex hull of points that span a volume, m, shape (k, 3).

    Of very many, those that are farthest in one of evenly spread directions, among them the axes.

    Args:
        points: m, shape (n, 3).
    """
    corners: Floats = points[ConvexHull(points).vertices]
    if len(corners) <= _MOST:
        return corners
    directions = np.vstack((np.eye(3), -np.eye(3), _spread(_MOST - 6)))
    kept = np.unique(np.argmax(directions @ corners.T, axis=1))
    few: Floats = corners[kept]
    return few


def hull_faces(corners: Floats) -> Faces:
    """Indices of the corners of a convex hull's triangles, shape (n, 3), in no order."""
    return np.asarray(ConvexHull(corners).simplices, dtype=np.intp)


def _spread(count: int) -> Floats:
    """Directions on a spiral from pole to pole, which spreads them evenly, shape (count, 3)."""
    steps = np.arange(count) + 0.5
    heights, angles = 1 - 2 * steps / count, math.pi * (1 + math.sqrt(5)) * steps
    across = np.sqrt(1 - heights**2)
    return np.column_stack((across * np.cos(angles), across * np.sin(angles), heights))
