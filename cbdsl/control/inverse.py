"""Damped inverses of a level's rows (Section 3.3.1, Eq 3.18)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cbdsl.control.signal import Floats

# Rows count as dependent where what is left of them is rounding of the Jacobian. What a larger
# tolerance would ignore, lower levels would be free to disturb.
ROUNDING = 1e-12

# Singular values above this part of the Jacobian can be had from the Gram matrix, which squares
# them: the rounding that it magnifies by the inverse square stays below 1e-12.
_CERTAIN = 0.03

_ONE = np.ones((1, 1))


@dataclass(frozen=True)
class Damping:
    """Levenberg-Marquardt damping, singular value by singular value.

    It grows from 0 at ``singular_value`` to ``most`` at 0, so that steps stay bounded and
    continuous through singularities, and are exact away from them.
    """

    most: float
    singular_value: float

    def inverse(self, values: Floats) -> Floats:
        """What stands for each singular value's inverse; ``values`` are largest first."""
        if not len(values) or values[-1] >= self.singular_value:
            return 1.0 / values
        squares = values * values
        weights = np.maximum(0.0, 1.0 - squares / self.singular_value**2)
        inverse: Floats = values / (squares + self.most * weights)
        return inverse


class Inverse(NamedTuple):
    """How to move k rows by the shortest displacement of n joints.

    Attributes:
        factor: movement along the directions per task coordinate, damped, shape (rank, k).
        directions: of the joints, orthonormal, shape (rank, n).
    """

    factor: Floats
    directions: Floats

    def displacement(self, velocity: Floats) -> Floats:
        """The displacement (n,) that moves the rows by ``velocity`` (k,), if damped."""
        displacement: Floats = self.factor.dot(velocity).dot(self.directions)
        return displacement


def from_singular_values(
    left: Floats, values: Floats, directions: Floats, damping: Damping
) -> Inverse:
    """The inverse of ``left * values @ directions``, values largest first."""
    return Inverse(damping.inverse(values)[:, None] * left.T, directions)


def from_gram_matrix(rows: Floats, size: float, damping: Damping) -> Inverse | None:
    """The inverse of rows by their Gram matrix, or ``None`` where that squares away too much.

    One to three rows that are clearly independent need no more than the matrix's triangular
    factor. Otherwise its eigenvectors are the left singular vectors, which do where they
    separate large singular values from rounding.

    Args:
        rows: shape (k, n).
        size: Frobenius norm of the rows before anything was subtracted from them.
        damping: near singularities.
    """
    gram = rows.dot(rows.T)
    least = (_CERTAIN * size) ** 2
    if len(gram) in _TRIANGLES:
        least_undamped = max(least, damping.singular_value**2)
        triangle = _TRIANGLES[len(gram)](gram.ravel().tolist(), least_undamped)
        if triangle is not None:
            factor = np.array(triangle)
            return Inverse(factor, factor.dot(rows))
    squares, left = _eigen(gram)
    if not squares[-1] > least:
        rank = int(np.count_nonzero(squares > least))
        ignored = left[:, rank:].T.dot(rows)
        if np.vdot(ignored, ignored) > (ROUNDING * size) ** 2:
            return None
        squares, left = squares[:rank], left[:, :rank]
    values = np.sqrt(squares)
    return from_singular_values(left, values, (left / values).T.dot(rows), damping)


def _eigen(gram: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues, largest first, and eigenvectors, in columns; one row needs no algorithm."""
    if len(gram) == 1:
        return gram[0], _ONE
    # Eigenvalues come smallest first, those of the negative matrix in the order wanted.
    values, vectors = np.linalg.eigh(-gram)
    return -values, vectors


Triangle = list[list[float]]


def _triangle_1(gram: Sequence[float], least: float) -> Triangle | None:
    """The inverse of the Cholesky factor, if all eigenvalues are certainly above ``least``."""
    (a,) = gram
    return [[1.0 / math.sqrt(a)]] if a > least else None


def _triangle_2(gram: Sequence[float], least: float) -> Triangle | None:
    """As above. The smaller eigenvalue is at least the determinant divided by the trace."""
    a, b, _, c = gram
    determinant, trace = a * c - b * b, a + c
    if not determinant > least * trace:
        return None
    x = 1.0 / math.sqrt(a)
    z = 1.0 / math.sqrt(determinant * x * x)
    return [[x, 0.0], [-b * x * x * z, z]]


def _triangle_3(gram: Sequence[float], least: float) -> Triangle | None:
    """As above. Two eigenvalues have at most half the trace, squared, as their product."""
    a, b, c, _, d, e, _, _, f = gram
    if not a > least:
        return None
    x = 1.0 / math.sqrt(a)
    p, q = b * x, c * x
    second = d - p * p
    if not second > least:
        return None
    y = 1.0 / math.sqrt(second)
    r = (e - p * q) * y
    third, trace = f - q * q - r * r, a + d + f
    if not 4.0 * a * second * third > least * trace * trace:
        return None
    z = 1.0 / math.sqrt(third)
    return [[x, 0.0, 0.0], [-p * x * y, y, 0.0], [(p * r * y - q) * x * z, -r * y * z, z]]


_TRIANGLES: Mapping[int, Callable[[Sequence[float], float], Triangle | None]] = {
    1: _triangle_1,
    2: _triangle_2,
    3: _triangle_3,
}
