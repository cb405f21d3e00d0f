"""Row spaces: orthonormal, whatever the rank and condition of the rows."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.inverse import Damping, Inverse
from cbdsl.control.row_space import RowSpace
from cbdsl.control.signal import Floats

UNDAMPED = Damping(0.0, 1e-300)


def composed(blocks: list[Floats]) -> RowSpace:
    space = RowSpace.empty(blocks[0].shape[1])
    for rows in blocks:
        inverse = space.inverse(rows, float(np.linalg.norm(rows)), UNDAMPED)
        space = space if inverse is None else space.extended(inverse)
    return space


@pytest.mark.parametrize("exponent", range(0, 17))
def test_nearly_dependent_rows_neither_leak_nor_spoil_the_basis(
    exponent: int, rng: np.random.Generator
) -> None:
    for _ in range(20):
        first = rng.normal(size=(3, 9))
        second = rng.normal(size=(3, 3)) @ first + 10.0**-exponent * rng.normal(size=(3, 9))
        space = composed([first, second])
        below = space.inverse(np.linalg.qr(rng.normal(size=(9, 9)))[0], 3.0, UNDAMPED)
        assert isinstance(below, Inverse)
        rank = len(below.directions)
        np.testing.assert_allclose(below.directions @ below.directions.T, np.eye(rank), atol=1e-13)
        step = below.displacement(rng.normal(size=9))
        # What counts as rounding, 1e-12 of the rows, is left to the step.
        assert np.abs(np.vstack((first, second)) @ step).max() < 5e-11


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_inverses_are_those_of_what_is_left(count: int, rng: np.random.Generator) -> None:
    above, rows = rng.normal(size=(3, 9)), rng.normal(size=(count, 9))
    space, size = composed([above]), float(np.linalg.norm(rows))
    rest = rows @ (np.eye(9) - np.linalg.pinv(above) @ above)
    velocity = rng.normal(size=count)
    inverse = space.inverse(rows, size, UNDAMPED)
    assert inverse is not None
    np.testing.assert_allclose(
        inverse.displacement(velocity), np.linalg.pinv(rest) @ velocity, atol=1e-12
    )
    values = space.singular_values(rows, size)
    np.testing.assert_allclose(values, np.linalg.svd(rest, compute_uv=False), atol=1e-13)


@pytest.mark.parametrize("above", [[0, 1, 2], [5, 6, 7], [0, 1, 6], [0, 4, 7]])
@pytest.mark.parametrize("scales", [[1.0, 1.0, 1.0, 1.0], [5.0, 0.5, -2.0, 3.0]])
def test_rows_that_read_single_joints_are_inverted_like_any_others(
    above: list[int], scales: list[float], rng: np.random.Generator
) -> None:
    """Above are a used-up joint, and rows in the same joints, in others, or across."""
    dense = np.zeros((2, 9))
    dense[:, above] = rng.normal(size=(2, 3))
    space = composed([np.eye(9)[8:], dense])
    rows = np.diag(scales) @ np.eye(9)[[2, 1, 0, 8]]
    rest = rows @ (np.eye(9) - np.linalg.pinv(dense) @ dense)
    rest[:, 8] = 0.0
    inverse = space.inverse(rows, float(np.linalg.norm(rows)), UNDAMPED)
    assert inverse is not None
    velocity = rng.normal(size=4)
    np.testing.assert_allclose(
        inverse.displacement(velocity), np.linalg.pinv(rest, rcond=1e-9) @ velocity, atol=1e-12
    )
    again = space.extended(inverse).inverse(rows, float(np.linalg.norm(rows)), UNDAMPED)
    assert again is None


@pytest.mark.parametrize("rows", [np.zeros((1, 4)), np.zeros((3, 4)), np.eye(1, 4)])
def test_rows_of_no_effect_are_not_inverted(rows: Floats) -> None:
    space = composed([np.eye(4)])
    size = float(np.linalg.norm(rows))
    assert space.inverse(rows, size, UNDAMPED) is None
    assert len(space.singular_values(rows, size)) == 0


def test_damping_is_bounded_and_meets_the_inverse_at_its_threshold() -> None:
    damping = Damping(0.01, 0.04)
    values = np.geomspace(1.0, 1e-9, 20_000)
    inverse = np.array([damping.inverse(values[i : i + 1])[0] for i in range(len(values))])
    assert inverse.max() <= 1 / 0.04 * (1 + 1e-9)
    assert (np.abs(np.diff(inverse)) < 0.5).all()
    np.testing.assert_allclose(inverse[values >= 0.04], 1 / values[values >= 0.04])
