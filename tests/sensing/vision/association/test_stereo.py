"""Triangulation by two lines of sight."""

import numpy as np
import pytest

from cbdsl.sensing.vision.association.stereo import Ray, triangulate


def ray(origin: np.ndarray, target: np.ndarray) -> Ray:
    line = target - origin
    return Ray(origin, line / np.linalg.norm(line))


@pytest.mark.parametrize("seed", range(20))
def test_lines_of_sight_to_a_point_cross_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    point = rng.uniform([0.3, -0.5, -0.5], [1.5, 0.5, 0.5])
    crossing = triangulate(
        ray(np.array([0, 0.15, 0.0]), point), ray(np.array([0, -0.15, 0.0]), point)
    )
    assert crossing is not None
    assert crossing.position == pytest.approx(point)
    assert crossing.gap == pytest.approx(0, abs=1e-9)


def test_gap_is_the_distance_between_skew_lines() -> None:
    left = Ray(np.zeros(3), np.array([1.0, 0, 0]))
    right = Ray(np.array([1.0, -1.0, 0.03]), np.array([0, 1.0, 0]))
    crossing = triangulate(left, right)
    assert crossing is not None
    assert crossing.gap == pytest.approx(0.03)
    assert crossing.position == pytest.approx([1.0, 0, 0.015])


def test_parallel_and_backward_lines_do_not_cross() -> None:
    ahead = np.array([1.0, 0, 0])
    assert triangulate(Ray(np.zeros(3), ahead), Ray(np.array([0, 0.3, 0]), ahead)) is None
    behind = np.array([-1.0, 0.2, 0])
    left, right = np.array([0, 0.15, 0.0]), np.array([0, -0.15, 0.0])
    assert triangulate(ray(left, behind), Ray(right, (right - behind) / 1.1)) is None


def test_direction_of_any_length_is_as_good_as_a_unit_vector() -> None:
    eye, other, point = (
        np.array([0, 0.15, 0.0]),
        np.array([0, -0.15, 0.0]),
        np.array([0.8, 0.1, -1]),
    )
    one, two = ray(eye, point), ray(other, point + 0.01)
    unit = triangulate(one, two)
    longer = triangulate(Ray(eye, 3 * one.direction, 3.0), two)
    assert unit is not None and longer is not None
    assert longer.position == pytest.approx(unit.position)
    assert longer.gap == pytest.approx(unit.gap)
