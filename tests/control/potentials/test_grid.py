"""Grids: cells, blocked cells, and connected cells."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.potentials.grid import BORDER, FREE, Grid
from cbdsl.kinematics.obstacle import Obstacle


@pytest.mark.parametrize("n", [1, 2, 3])
def test_every_point_belongs_to_its_nearest_vertex(n: int, rng: np.random.Generator) -> None:
    grid = Grid.between(np.full(n, -1.0), np.full(n, 1.05), 0.1)
    assert grid.shape == (21,) * n
    for point in rng.uniform(-1, 1, (50, n)):
        vertex = grid.nearest(point)
        assert vertex is not None
        assert np.abs(grid.position(vertex) - point).max() <= 0.05 + 1e-12
    assert grid.nearest(np.full(n, 1.2)) is None
    assert grid.nearest(np.full(n, -1.2)) is None


@pytest.mark.parametrize("n", [1, 2, 3])
def test_vertex_is_blocked_exactly_where_its_cell_touches_an_obstacle(
    n: int, rng: np.random.Generator
) -> None:
    grid = Grid.between(np.zeros(n), np.ones(n), 0.1)
    for _ in range(5):
        lower = rng.uniform(0.1, 0.8, n)
        obstacle = Obstacle(
            "box", lower, lower + rng.uniform(0, 0.2, n), float(rng.uniform(0, 0.1))
        )
        owners = grid.owners([obstacle])
        for vertex in np.ndindex(*grid.shape):
            here = grid.position(vertex)
            # The point of the cell that is nearest to the box, axis by axis.
            nearest = np.clip(
                np.clip(here, obstacle.lower, obstacle.upper), here - 0.05, here + 0.05
            )
            is_border = any(i in (0, 10) for i in vertex)
            touched = obstacle.distance(nearest) <= 1e-12
            assert owners[vertex] == (BORDER if is_border else 0 if touched else FREE)


def test_wall_thinner_than_a_cell_separates() -> None:
    grid = Grid.between(np.zeros(3), np.ones(3), 0.1)
    wall = Obstacle("wall", np.array([0.449, 0.0, 0.0]), np.array([0.451, 1.0, 1.0]))
    free = grid.owners([wall]) == FREE
    side = grid.connected(free, (1, 1, 1))
    assert side.any() and not side[6:].any()
    assert (side | grid.connected(free, (9, 9, 9)) == free).all()


def test_connected_is_everything_without_obstacles_and_one_vertex_in_a_cage() -> None:
    grid = Grid.between(np.zeros(2), np.ones(2), 0.1)
    free = grid.owners([]) == FREE
    assert (grid.connected(free, (5, 5)) == free).all()
    for neighbour in ((4, 5), (6, 5), (5, 4), (5, 6)):
        free[neighbour] = False
    assert np.argwhere(grid.connected(free, (5, 5))).tolist() == [[5, 5]]


@pytest.mark.parametrize(
    ("lower", "upper", "spacing"),
    [
        ([0.0], [0.1], 0.1),
        ([0.0, 0.0], [1.0, -1.0], 0.1),
        ([0.0] * 4, [1.0] * 4, 0.1),
        ([0.0], [np.inf], 0.1),
        ([0.0], [1.0], 0.0),
    ],
)
def test_grids_without_an_inside_are_refused(
    lower: list[float], upper: list[float], spacing: float
) -> None:
    with pytest.raises(ValueError, match="grid"):
        Grid.between(np.array(lower), np.array(upper), spacing)
