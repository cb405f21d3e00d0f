"""The law's arithmetic: exact for every rank and condition of the rows."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.composition import ComposedArrays, compose_held
from cbdsl.control.half_tick import extrapolate_half_tick
from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.level import LevelArrays
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.handle import hold

FREE = 1e300


def composed(blocks: list[Floats], wanted: list[Floats]) -> tuple[Floats, Floats]:
    """Return the displacement and singular values of levels without limits, bounds or damping."""
    joints = blocks[0].shape[1]
    limits = np.array([np.full(joints, -FREE), np.full(joints, FREE)])
    ends = np.cumsum([len(rows) for rows in blocks])
    rows = np.stack([np.vstack(blocks)] * 3)
    step, locked, values = np.empty(joints), np.empty(joints, dtype=bool), np.empty(ends[-1])
    count = len(blocks)
    levels = LevelArrays(
        np.zeros(1, dtype=int), rows, np.ones(count, dtype=int), np.concatenate(wanted), ends,
        np.ones(count), np.zeros(count), np.zeros(count, dtype=bool),
        np.zeros((ends[-1], joints, joints)), np.zeros(count, dtype=int), np.zeros(1, dtype=bool),
        np.zeros(ends[-1]), np.zeros(ends[-1], dtype=bool),
    )  # fmt: skip
    steps, guards = np.full(joints, FREE), np.array([0.0, 1e-300, FREE])
    law = LawArrays(limits, steps, guards, step, locked, values)
    compose_held(hold(ComposedArrays(levels, law)), np.zeros(joints), False)
    assert not locked.any()
    return step, values


@pytest.mark.parametrize("exponent", range(0, 17))
def test_nearly_dependent_rows_do_not_leak_or_disturb_lower_levels(
    exponent: int, rng: np.random.Generator
) -> None:
    for _ in range(20):
        first = rng.normal(size=(3, 9))
        second = rng.normal(size=(3, 3)) @ first + 10.0**-exponent * rng.normal(size=(3, 9))
        wanted = rng.normal(size=9)
        blocks = [first, second, np.eye(9)]
        step, values = composed(blocks, [np.zeros(3), np.zeros(3), wanted])
        # Singular values up to the rounding threshold, 1e-13 of the rows, are left to the step.
        assert np.abs(np.vstack((first, second)) @ step).max() < 1e-11
        rank = np.count_nonzero(values[:6])
        np.testing.assert_allclose(sorted(values[6:]), [0.0] * rank + [1.0] * (9 - rank), atol=1e-9)
        # The shortest way: a projection of the desired displacement.
        assert step @ step == pytest.approx(step @ wanted)


@pytest.mark.parametrize("count", [1, 2, 3, 5, 7])
def test_level_moves_by_the_pseudoinverse_of_its_remaining_rows(
    count: int, rng: np.random.Generator
) -> None:
    above, rows = rng.normal(size=(2, 9)), rng.normal(size=(count, 9))
    velocities = [rng.normal(size=2), rng.normal(size=count)]
    rest = rows @ (np.eye(9) - np.linalg.pinv(above) @ above)
    first = np.linalg.pinv(above) @ velocities[0]
    expected = first + np.linalg.pinv(rest) @ (velocities[1] - rows @ first)
    step, values = composed([above, rows], velocities)
    np.testing.assert_allclose(step, expected, atol=1e-10)
    found = np.sort(values[2:])[::-1]
    np.testing.assert_allclose(found, np.linalg.svd(rest, compute_uv=False), atol=1e-13)


@pytest.mark.parametrize("count", [2, 3, 5, 7])
@pytest.mark.parametrize("exponent", [4, 8, 12])
def test_singular_values_of_nearly_dependent_rows_agree_with_numpy(
    count: int, exponent: int, rng: np.random.Generator
) -> None:
    """Compute them in a bounded number of sweeps in spite of rounding in nearly parallel rows."""
    for _ in range(50):
        rows = np.outer(rng.normal(size=count), rng.normal(size=14))
        rows += 10.0**-exponent * rng.normal(size=rows.shape)
        values = np.sort(composed([rows], [np.zeros(count)])[1])[::-1]
        expected = np.linalg.svd(rows, compute_uv=False)
        np.testing.assert_allclose(values, expected, atol=1e-13 * expected[0] * count)


def test_rows_half_a_tick_ahead_are_exact_for_parabolas(rng: np.random.Generator) -> None:
    position, rate, acceleration = rng.normal(size=(3, 2, 4))

    def rows(time: float) -> Floats:
        found: Floats = position + rate * time + acceleration * time**2
        return found

    # The newest of the three may be anywhere in them.
    ticks = np.stack((rows(-1), rows(0), rows(-2)))
    found = extrapolate_half_tick(ticks, 1, np.array([3]), np.array([2]))
    np.testing.assert_allclose(found, rows(0.5), atol=1e-12)


def test_rows_half_a_tick_ahead_go_by_as_many_ticks_as_each_level_has_acted(
    rng: np.random.Generator,
) -> None:
    position, rate, unknown = rng.normal(size=(3, 4, 5))
    rows = np.stack((position - rate, unknown, position))
    ages, ends = np.array([2, 1, 0]), np.array([1, 2, 4])
    found = extrapolate_half_tick(rows, 2, ages, ends)
    np.testing.assert_allclose(found[0], position[0] + 0.5 * (position[0] - unknown[0]), atol=1e-12)
    np.testing.assert_array_equal(found[1], position[1])
    np.testing.assert_array_equal(found[2:], 0.0)


@pytest.mark.parametrize("rows", [np.zeros((1, 4)), np.zeros((3, 4)), np.eye(1, 4)])
def test_rows_of_no_effect_move_nothing(rows: Floats) -> None:
    step, values = composed([np.eye(4), rows], [np.ones(4), np.full(len(rows), 7.0)])
    np.testing.assert_allclose(step, np.ones(4))
    np.testing.assert_array_equal(values[4:], 0.0)
    step, values = composed([np.zeros((3, 4)), rows], [np.ones(3), np.zeros(len(rows))])
    np.testing.assert_array_equal(step, np.zeros(4))


@pytest.mark.parametrize("scale", [1e-160, 1e-80, 1e80, 1e140])
def test_composition_of_extreme_numbers_terminates(scale: float, rng: np.random.Generator) -> None:
    step, _ = composed([scale * rng.normal(size=(3, 5))], [scale * rng.normal(size=3)])
    assert np.isfinite(step).all()
