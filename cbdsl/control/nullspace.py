"""The joint displacements that higher levels of a composition do not notice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.control.signal import Floats

# Rows count as dependent where their singular value is rounding of the Jacobian. What a larger
# tolerance would ignore, lower levels would be free to disturb.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Damping:
    """Levenberg-Marquardt damping, singular value by singular value.

    It grows from 0 at ``singular_value`` to ``most`` at 0, so that steps stay bounded and
    continuous through singularities, and are exact away from them.
    """

    most: float
    singular_value: float

    def gains(self, singular_values: Floats) -> Floats:
        """Displacement per task displacement along each singular direction."""
        squares = singular_values * singular_values
        weights = np.maximum(0.0, 1.0 - squares / self.singular_value**2)
        gains: Floats = singular_values / (squares + self.most * weights)
        return gains


class Nullspace:
    """A subspace of joint displacements, by an orthonormal basis, shape (n, r).

    Rows are decomposed in the basis' own coordinates. Its columns so stay orthonormal however
    ill-conditioned the rows are, which a projector I - J^# J does not.
    """

    def __init__(self, basis: Floats) -> None:
        self._basis = basis

    @classmethod
    def whole(cls, joints: int) -> Nullspace:
        """Every displacement of ``joints`` joints."""
        return cls(np.eye(joints))

    def decompose(self, rows: Floats) -> Decomposition:
        """What displacements of this subspace do to ``rows``, shape (k, n)."""
        left, values, right = np.linalg.svd(rows @ self._basis)
        rank = int(np.count_nonzero(values > _ROUNDING * np.linalg.norm(rows)))
        return Decomposition(self._basis, left[:, :rank], values[:rank], right)


@dataclass(frozen=True)
class Decomposition:
    """Singular value decomposition of k rows within a subspace of r dimensions.

    Attributes:
        basis: of the subspace, shape (n, r).
        left: singular directions of the rows, shape (k, rank).
        values: singular values above rounding, largest first, shape (rank,).
        right: singular directions in coordinates of the basis, shape (r, r).
    """

    basis: Floats
    left: Floats
    values: Floats
    right: Floats

    def displacement(self, velocity: Floats, damping: Damping) -> Floats:
        """The shortest displacement (n,) in the subspace that moves the rows by ``velocity``."""
        along = damping.gains(self.values) * (velocity @ self.left)
        displacement: Floats = self.basis @ (along @ self.right[: len(self.values)])
        return displacement

    def remaining(self) -> Nullspace:
        """The part of the subspace that moves none of the rows."""
        return Nullspace(self.basis @ self.right[len(self.values) :].T)
