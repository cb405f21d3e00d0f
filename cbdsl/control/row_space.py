"""The joint displacements that the levels of a composition respond to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.control.signal import Floats

# Rows count as dependent where what is left of them is rounding of the Jacobian. What a larger
# tolerance would ignore, lower levels would be free to disturb.
_ROUNDING = 1e-12

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
        along = velocity.dot(self.left) * damping.inverse(self.values)
        displacement: Floats = along.dot(self.right)
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

        The eigenvectors of the small Gram matrix are the left singular vectors. Where they
        separate large singular values from rounding, that is all; anything in between takes a
        singular value decomposition and a second orthogonalisation.

        Args:
            rows: shape (k, n).
            size: their Frobenius norm.
        """
        count, joints = rows.shape
        if len(self._basis) == joints:
            return Decomposition(np.empty((count, 0)), np.empty(0), np.empty((0, joints)))
        rest = self._outside(rows)
        squares, left = _eigen(rest.dot(rest.T))
        least = (_CERTAIN * size) ** 2
        if not squares[-1] > least:
            rank = int(np.count_nonzero(squares > least))
            ignored = left[:, rank:].T.dot(rest)
            if np.vdot(ignored, ignored) > (_ROUNDING * size) ** 2:
                return self._decompose_carefully(rest, size)
            squares, left = squares[:rank], left[:, :rank]
        values = np.sqrt(squares)
        return Decomposition(left, values, (left / values).T.dot(rest))

    def _decompose_carefully(self, rest: Floats, size: float) -> Decomposition:
        left, values, right = np.linalg.svd(rest, full_matrices=False)
        rank = int(np.count_nonzero(values > _ROUNDING * size))
        left, values, right = left[:, :rank], values[:rank], right[:rank]
        # What was subtracted left rounding, which small singular values have magnified.
        return Decomposition(left, values, self._orthonormal(self._outside(right)))

    def _outside(self, rows: Floats) -> Floats:
        """What is left of rows (k, n) at right angles to this space."""
        if not len(self._basis):
            return rows
        # ``dot`` does the same as ``@`` in half the time where matrices are this small.
        outside: Floats = rows - rows.dot(self._basis.T).dot(self._basis)
        return outside

    def _orthonormal(self, directions: Floats) -> Floats:
        """Rows (k, n), nearly orthonormal, made so; at right angles to this space as well."""
        above = len(self._basis)
        columns, triangle = np.linalg.qr(np.concatenate((self._basis, directions)).T)
        signs = np.sign(np.diagonal(triangle)[above:])
        oriented: Floats = columns[:, above:].T * signs[:, None]
        return oriented


def _eigen(gram: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues, largest first, and eigenvectors, in columns; one row needs no algorithm."""
    if len(gram) == 1:
        return gram[0], _ONE
    # Eigenvalues come smallest first, those of the negative matrix in the order wanted.
    values, vectors = np.linalg.eigh(-gram)
    return -values, vectors
