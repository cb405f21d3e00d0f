"""Obstacles: distances, and the displacements that count as motion."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.kinematics.obstacle import Obstacle


@pytest.mark.parametrize("n", [1, 2, 3])
def test_distance_is_that_to_the_nearest_point(n: int, rng: np.random.Generator) -> None:
    for _ in range(20):
        lower = rng.uniform(-1, 0, n)
        obstacle = Obstacle("box", lower, lower + rng.uniform(0.1, 1, n), float(rng.uniform(0, 1)))
        point = rng.uniform(-3, 3, n)
        inside = np.clip(point, obstacle.lower, obstacle.upper)
        assert obstacle.distance(point) == pytest.approx(
            np.linalg.norm(point - inside) - obstacle.radius
        )


def test_sphere_is_a_point_with_a_radius() -> None:
    ball = Obstacle.sphere("ball", np.array([1.0, 2.0, 3.0]), 0.5)
    assert ball.distance(np.array([1.0, 2.0, 5.0])) == pytest.approx(1.5)
    assert ball.grown(0.25).distance(np.array([1.0, 2.0, 5.0])) == pytest.approx(1.25)


def test_gaps_make_up_the_distance(rng: np.random.Generator) -> None:
    obstacle = Obstacle("box", np.array([-1.0, 0.0]), np.array([1.0, 0.5]))
    points = rng.uniform(-3, 3, (20, 2))
    gaps = np.stack([obstacle.gaps(points[:, axis], axis) for axis in range(2)])
    np.testing.assert_allclose(np.hypot(*gaps), [obstacle.distance(x) for x in points])


def test_differs_by_more_than_the_tolerance_in_any_part() -> None:
    ball = Obstacle.sphere("ball", np.zeros(3), 0.5)
    near = Obstacle.sphere("ball", np.full(3, 0.01), 0.51)
    assert not ball.differs(near, 0.02)
    assert ball.differs(near, 0.005)
    assert ball.differs(ball._replace(radius=0.6), 0.02)
    assert ball.differs(ball._replace(upper=np.array([0.0, 0.0, 0.1])), 0.02)
    assert ball.differs(ball._replace(name="another"), 0.02)


def test_shaft_is_the_only_free_part_of_its_box(rng: np.random.Generator) -> None:
    """Remove the shaft at every goal, also if it is partly or wholly beside the box."""
    box = Obstacle("table", np.array([-1.0, -2.0, -0.5]), np.array([1.0, 2.0, 0.0]))
    for _ in range(30):
        goal = rng.uniform([-2, -3, -0.5], [2, 3, 0.5])
        half = float(rng.uniform(0.05, 0.5))
        parts = box.around(goal, half)
        assert len(parts) <= 4 and {part.name for part in parts} == {"table"}
        for point in rng.uniform([-1.2, -2.2, -0.7], [1.2, 2.2, 0.2], (200, 3)):
            beside = np.abs(point[:2] - goal[:2]).max() >= half
            within = any(part.distance(point) <= 0.0 for part in parts)
            assert within == (beside and box.distance(point) <= 0.0)
