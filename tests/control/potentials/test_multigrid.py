"""Multigrid against dense solutions, over random obstacles in one to three dimensions."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.potentials.multigrid import Multigrid, neighbour_sum
from cbdsl.numeric.arrays import Booleans, Floats

SHAPES = [(12,), (33,), (13, 18), (9, 9, 12), (3, 20), (4, 4, 4)]


def random_scene(shape: tuple[int, ...], rng: np.random.Generator) -> tuple[Booleans, Floats]:
    free = rng.uniform(size=shape) < 0.85
    for axis in range(len(shape)):
        np.moveaxis(free, axis, 0)[[0, -1]] = False
    middle = tuple(n // 2 for n in shape)
    free[middle] = True
    source = np.zeros(shape)
    source[middle] = 1.0
    return free, source


def dense_solution(free: Booleans, source: Floats) -> Floats:
    vertices = np.argwhere(free)
    apart = np.abs(vertices[:, None] - vertices[None]).sum(axis=2)
    matrix = 2.0 * free.ndim * np.eye(len(vertices)) - (apart == 1)
    u = np.zeros(free.shape)
    u[free] = np.linalg.solve(matrix, source[free])
    return u


@pytest.mark.parametrize("shape", SHAPES)
def test_multigrid_solution_equals_the_dense_solution(
    shape: tuple[int, ...], rng: np.random.Generator
) -> None:
    for _ in range(4):
        free, source = random_scene(shape, rng)
        u, _ = Multigrid(free).solve(source, accuracy=1e-9, floor=1e-6)
        np.testing.assert_allclose(u, dense_solution(free, source), atol=1e-10)


def test_cycles_do_not_grow_with_the_grid() -> None:
    cycles = []
    for cells in (16, 32, 64, 128, 256):
        free = np.zeros((cells + 1, cells + 1), bool)
        free[1:-1, 1:-1] = True
        source = np.zeros(free.shape)
        source[cells // 3, cells // 3] = 1.0
        cycles.append(Multigrid(free).solve(source, accuracy=1e-6, floor=1e-8)[1])
    assert max(cycles) <= 12


def test_multigrid_with_a_start_needs_fewer_cycles(rng: np.random.Generator) -> None:
    free, source = random_scene((40, 40), rng)
    multigrid = Multigrid(free)
    u, cold = multigrid.solve(source, accuracy=1e-6, floor=1e-8)
    again, warm = multigrid.solve(source, u, accuracy=1e-6, floor=1e-8)
    assert (cold > 3, warm) == (True, 0)
    np.testing.assert_array_equal(u, again)


@pytest.mark.parametrize("shape", SHAPES)
def test_neighbour_sum_equals_the_sum_of_shifted_arrays(
    shape: tuple[int, ...], rng: np.random.Generator
) -> None:
    u = rng.normal(size=shape)
    inside = (slice(1, -1),) * len(shape)
    wanted = sum(np.roll(u, step, axis) for axis in range(u.ndim) for step in (-1, 1))
    np.testing.assert_allclose(neighbour_sum(u)[inside], np.asarray(wanted)[inside])
