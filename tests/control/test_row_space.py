"""Row spaces: orthonormal, whatever the rank and condition of the rows."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.row_space import Damping, RowSpace
from cbdsl.control.signal import Floats

UNDAMPED = Damping(0.0, 1e-300)


def composed(blocks: list[Floats]) -> RowSpace:
    space = RowSpace.empty(blocks[0].shape[1])
    for rows in blocks:
        space = space.extended(space.decompose(rows, float(np.linalg.norm(rows))))
    return space


@pytest.mark.parametrize("exponent", range(0, 17))
def test_nearly_dependent_rows_neither_leak_nor_spoil_the_basis(
    exponent: int, rng: np.random.Generator
) -> None:
    for _ in range(20):
        first = rng.normal(size=(3, 9))
        second = rng.normal(size=(3, 3)) @ first + 10.0**-exponent * rng.normal(size=(3, 9))
        space = composed([first, second])
        last = np.eye(9)
        below = space.decompose(last, 3.0)
        np.testing.assert_allclose(
            below.right @ below.right.T, np.eye(len(below.values)), atol=1e-13
        )
        step = below.displacement(rng.normal(size=9), UNDAMPED)
        assert np.abs(np.vstack((first, second)) @ step).max() < 1e-11


def test_decomposition_reproduces_what_is_left(rng: np.random.Generator) -> None:
    for count in (1, 2, 5):
        above, rows = rng.normal(size=(3, 9)), rng.normal(size=(count, 9))
        left = composed([above]).decompose(rows, float(np.linalg.norm(rows)))
        rest = rows @ (np.eye(9) - np.linalg.pinv(above) @ above)
        np.testing.assert_allclose((left.left * left.values) @ left.right, rest, atol=1e-13)
        assert (np.diff(left.values) <= 0).all()


@pytest.mark.parametrize("rows", [np.zeros((1, 4)), np.zeros((3, 4)), np.eye(1, 4)])
def test_rows_of_no_effect_have_no_rank(rows: Floats) -> None:
    decomposition = composed([np.eye(4)]).decompose(rows, float(np.linalg.norm(rows)))
    assert len(decomposition.values) == 0
    step = decomposition.displacement(np.ones(len(rows)), UNDAMPED)
    np.testing.assert_array_equal(step, np.zeros(4))


def test_damping_is_bounded_and_meets_the_inverse_at_its_threshold() -> None:
    damping = Damping(0.01, 0.04)
    values = np.geomspace(1.0, 1e-9, 20_000)
    inverse = np.array([damping.inverse(values[i : i + 1])[0] for i in range(len(values))])
    assert inverse.max() <= 1 / 0.04 * (1 + 1e-9)
    assert (np.abs(np.diff(inverse)) < 0.5).all()
    np.testing.assert_allclose(inverse[values >= 0.04], 1 / values[values >= 0.04])
