"""Convex hulls: few corners, and nothing lost at the ends."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.numeric.convex_hull import hull_corners, hull_faces


def test_inner_points_are_no_corners() -> None:
    rng = np.random.default_rng(0)
    signs = np.array(np.meshgrid([1, -1], [1, -1], [1, -1])).reshape(3, -1).T.astype(float)
    corners = hull_corners(np.vstack((signs, rng.uniform(-0.9, 0.9, (50, 3)))))
    assert len(corners) == 8
    assert len(hull_faces(corners)) == 12


def test_hull_of_many_corners_keeps_few_and_its_extents() -> None:
    rng = np.random.default_rng(1)
    points = rng.standard_normal((4000, 3))
    points *= 0.1 / np.linalg.norm(points, axis=1, keepdims=True)
    corners = hull_corners(points)
    assert 100 <= len(corners) <= 128
    assert corners.max(axis=0) == pytest.approx(points.max(axis=0))
    assert corners.min(axis=0) == pytest.approx(points.min(axis=0))
    directions = rng.standard_normal((500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    reach = (directions @ corners.T).max(axis=1)
    assert reach.min() > 0.1 * 0.97, "a dent of 3 % at most"
