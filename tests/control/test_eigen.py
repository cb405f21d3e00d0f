"""Eigenvalues of small symmetric matrices."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from cbdsl.control.second_order import diagonalize
from cbdsl.numeric.arrays import Floats


@njit
def diagonalized(matrix: Floats, vectors: Floats) -> None:
    diagonalize(matrix, vectors)


@pytest.mark.parametrize("size", [1, 2, 3, 7, 14])
def test_diagonalize_symmetric_matrix_agrees_with_lapack(
    size: int, rng: np.random.Generator
) -> None:
    for rank in range(size + 1):
        factor = rng.normal(size=(size, rank))
        given = factor @ np.diag(rng.normal(size=rank)) @ factor.T
        matrix, vectors = given.copy(), np.empty((size, size))
        diagonalized(matrix, vectors)
        np.testing.assert_allclose(vectors @ vectors.T, np.eye(size), atol=1e-13)
        np.testing.assert_allclose(vectors @ given @ vectors.T, matrix, atol=1e-12)
        expected = np.linalg.eigvalsh(given)
        np.testing.assert_allclose(np.sort(np.diag(matrix)), expected, atol=1e-12)
