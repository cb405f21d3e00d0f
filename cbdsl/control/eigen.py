"""Eigenvalues of small symmetric matrices; compiled."""

from __future__ import annotations

import math

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled

# Sweeps converge quadratically; further ones do not reduce rounding errors.
_SWEEPS = 12

# Elements count as zero at this share of the diagonal elements beside them.
_ROUNDING = 1e-15


@compiled
def diagonalize(matrix: Floats, vectors: Floats) -> None:
    """Diagonalize a symmetric matrix by cyclic Jacobi rotations.

    Args:
        matrix: Symmetric matrix, shape (m, m); becomes diagonal, with the eigenvalues unsorted.
        vectors: Becomes the eigenvectors, one a row, shape (m, m).
    """
    size = len(matrix)
    for i in range(size):
        for j in range(size):
            vectors[i, j] = 1.0 if i == j else 0.0
    scale = 0.0
    for i in range(size):
        for j in range(size):
            scale = max(scale, abs(matrix[i, j]))
    for _ in range(_SWEEPS):
        turned = False
        for i in range(size - 1):
            for j in range(i + 1, size):
                if abs(matrix[i, j]) > _ROUNDING * scale:
                    _rotate(matrix, vectors, i, j)
                    turned = True
        if not turned:
            break


@compiled
def _rotate(matrix: Floats, vectors: Floats, i: int, j: int) -> None:
    """Turn two coordinates so that the element between them vanishes."""
    ratio = (matrix[j, j] - matrix[i, i]) / (2.0 * matrix[i, j])
    tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine, change = tangent * cosine, tangent * matrix[i, j]
    matrix[i, i] -= change
    matrix[j, j] += change
    matrix[i, j] = matrix[j, i] = 0.0
    for k in range(len(matrix)):
        if k not in (i, j):
            one, other = matrix[i, k], matrix[j, k]
            matrix[i, k] = matrix[k, i] = cosine * one - sine * other
            matrix[j, k] = matrix[k, j] = sine * one + cosine * other
        one, other = vectors[i, k], vectors[j, k]
        vectors[i, k], vectors[j, k] = cosine * one - sine * other, sine * one + cosine * other
