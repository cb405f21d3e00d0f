"""Closest points of hulls agree with coal's, which is other code."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from cbdsl.kinematics.closest_points import closest_points

TINY = 1e-9  # m, radius of points and lines


def drawn(rng: np.random.Generator, size: int) -> tuple[np.ndarray, object, object]:
    """Return a random hull, and the same as geometry and placement of coal."""
    half, place = rng.uniform(0.02, 0.3, 3), rng.uniform(-0.6, 0.6, 3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn = np.eye(3) if rng.random() < 0.3 else turn * np.linalg.det(turn)
    corners = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T * half
    own = {1: np.zeros((1, 3)), 2: np.array([[0, 0, -half[2]], [0, 0, half[2]]]), 8: corners}[size]
    shape = {1: coal.Sphere(TINY), 2: coal.Capsule(TINY, 2 * half[2]), 8: coal.Box(*(2 * half))}
    return own @ turn.T + place, shape[size], coal.Transform3s(turn, place)


@pytest.mark.parametrize("first", [1, 2, 8])
@pytest.mark.parametrize("second", [1, 2, 8])
def test_closest_points_of_random_hulls_are_those_of_coal(first: int, second: int) -> None:
    rng, ends = np.random.default_rng([first, second]), np.zeros((2, 3))
    simplex = np.full((4, 2), -1)
    for _ in range(100):
        (own, shape, at), (other, beside, there) = drawn(rng, first), drawn(rng, second)
        points, size = np.vstack([own, other]), len(own)
        spans = np.array((0, size)), np.array((size, len(points)))
        found = closest_points(points, *spans, simplex, ends)
        result = coal.DistanceResult()
        wanted = coal.distance(shape, at, beside, there, coal.DistanceRequest(), result)
        assert found == pytest.approx(max(wanted, 0.0), abs=1e-7)
        if found > 0.0:
            assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(found)


def test_closest_points_of_a_hull_with_coinciding_corners_are_found() -> None:
    points = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [0.5, 0.2, 0]])
    ends = np.zeros((2, 3))
    spans, simplex = (np.array((0, 4)), np.array((4, 5))), np.full((4, 2), -1)
    assert closest_points(points, *spans, simplex, ends) == pytest.approx(0.2)
    assert ends[0] == pytest.approx([0.5, 0.0, 0.0])


@pytest.mark.parametrize("first", [2, 8])
@pytest.mark.parametrize("second", [2, 8])
def test_search_from_corners_of_earlier_postures_finds_the_same_points(
    first: int, second: int
) -> None:
    rng, ends = np.random.default_rng([first, second]), np.zeros((2, 3))
    overlaps = 0
    for _ in range(30):
        own, other = drawn(rng, first)[0], drawn(rng, second)[0]
        simplex, way = np.full((4, 2), -1), rng.normal(size=3)
        spans = np.array((0, len(own))), np.array((len(own), len(own) + len(other)))
        for share in np.linspace(-0.5, 0.5, 30):
            points = np.vstack([own + share * way, other])
            found = closest_points(points, *spans, simplex, ends)
            afresh = np.zeros((2, 3))
            wanted = closest_points(points, *spans, np.full((4, 2), -1), afresh)
            overlaps += found == 0.0
            assert found == pytest.approx(wanted, abs=1e-7)
            if found > 1e-3:
                assert (ends[0] - ends[1]) / found == pytest.approx(
                    (afresh[0] - afresh[1]) / found, abs=1e-3
                )
    assert overlaps or (first, second) == (2, 2)
