"""The joint displacements that the levels of a composition respond to."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cbdsl.control.signal import Floats

# Rows count as dependent where what is left of them is rounding of the Jacobian. What a larger
# tolerance would ignore, lower levels would be free to disturb.
_ROUNDING = 1e-12

# Singular directions of smaller values, relative to the Jacobian, carry so much rounding that
# subtracting it would shorten them.
_UNCERTAIN = 1e-4

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
        if values[-1] >= self.singular_value:
            return 1.0 / values
        squares = values * values
        weights = np.maximum(0.0, 1.0 - squares / self.singular_value**2)
        inverse: Floats = values / (squares + self.most * weights)
        return inverse


@dataclass(frozen=True)
class Decomposition:
    """Singular value decomposition of what a row space leaves of k rows.

    Attributes:
        left: singular directions of the rows, shape (k, rank).
        values: singular values above rounding, largest first, shape (rank,).
        right: singular directions of the joints, orthonormal to the row space, shape (rank, n).
    """

    left: Floats
    values: Floats
    right: Floats

    def displacement(self, velocity: Floats, damping: Damping) -> Floats:
        """The shortest displacement (n,) that moves the rows by ``velocity`` (k,), if damped."""
        if not len(self.values):
            return np.zeros(self.right.shape[1])
        along = velocity @ self.left * damping.inverse(self.values)
        displacement: Floats = along @ self.right
        return displacement


class RowSpace:
    """The span of all rows composed so far, by an orthonormal basis, shape (m, n).

    A displacement at right angles to it is one that no level above notices. The basis serves as
    an exact projector, whatever the ranks and conditions of the rows; I - J^# J does not.
    """

    def __init__(self, basis: Floats) -> None:
        self._basis = basis

    @classmethod
    def empty(cls, joints: int) -> RowSpace:
        """The row space of no rows."""
        return cls(np.empty((0, joints)))

    def extended(self, decomposition: Decomposition) -> RowSpace:
        """The row space with the decomposed rows added."""
        if not len(self._basis):
            return RowSpace(decomposition.right)
        return RowSpace(np.concatenate((self._basis, decomposition.right)))

    def decompose(self, rows: Floats, size: float) -> Decomposition:
        """Decompose what lies outside of this space.

        Args:
            rows: shape (k, n).
            size: their Frobenius norm.
        """
        above = len(self._basis)
        rest = rows - (rows @ self._basis.T) @ self._basis if above else rows
        left, values, right = _svd(rest)
        rank = len(values)
        if rank and values[-1] <= _ROUNDING * size:
            rank = int(np.count_nonzero(values > _ROUNDING * size))
            left, values, right = left[:, :rank], values[:rank], right[:rank]
        if above and rank:
            # The subtraction above left rounding, which the singular values have magnified.
            right = right - (right @ self._basis.T) @ self._basis
            if values[-1] < _UNCERTAIN * size:
                right = self._orthonormal(right)
        return Decomposition(left, values, right)

    def _orthonormal(self, directions: Floats) -> Floats:
        above = len(self._basis)
        columns, triangle = np.linalg.qr(np.concatenate((self._basis, directions)).T)
        signs = np.sign(np.diagonal(triangle)[above:])
        oriented: Floats = columns[:, above:].T * signs[:, None]
        return oriented


def _svd(rows: Floats) -> tuple[Floats, Floats, Floats]:
    """Thin singular value decomposition; a single row needs no algorithm."""
    if len(rows) != 1:
        return np.linalg.svd(rows, full_matrices=False)
    length = math.sqrt(float(np.vdot(rows, rows)))
    return _ONE, np.array((length,)), rows / length if length else rows
