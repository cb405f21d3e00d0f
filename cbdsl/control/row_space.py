"""The joint displacements that the levels of a composition respond to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.control.inverse import (
    ROUNDING,
    Damping,
    Inverse,
    from_gram_matrix,
    from_singular_values,
)
from cbdsl.control.selection import Booleans, Selection
from cbdsl.control.signal import Floats


class Selected(NamedTuple):
    """How to move k rows that each read one joint, without a decomposition.

    All of these joints are used up afterwards.

    Attributes:
        rows: divided by the squares of their numbers, shape (k, n).
        joints: whether a row reads the joint, shape (n,).
        within: the basis above, as far as it lies in these joints, shape (m, n).
        beside: the basis above, as far as it lies in other joints.
    """

    rows: Floats
    joints: Booleans
    within: Floats
    beside: Floats

    def displacement(self, velocity: Floats) -> Floats:
        """The shortest displacement (n,) that moves the rows by ``velocity`` (k,)."""
        displacement: Floats = velocity.dot(self.rows)
        if not len(self.within):
            return displacement
        beside: Floats = displacement - displacement.dot(self.within.T).dot(self.within)
        return beside


class RowSpace:
    """The span of all rows composed so far: joints that are used up, and a basis of the rest.

    A displacement at right angles to it is one that no level above notices. An orthonormal basis
    serves as an exact projector, whatever the ranks and conditions of the rows; I - J^# J does
    not.

    Args:
        used: whether a joint is used up, shape (n,).
        basis: orthonormal rows in the other joints, shape (m, n).

    Attributes:
        room: independent displacements that are left.
    """

    def __init__(self, used: Booleans, basis: Floats) -> None:
        self._used = used
        self._basis = basis
        count = np.count_nonzero(used)
        self._free = (~used).astype(np.float64) if count else None
        self.room = len(used) - count - len(basis)

    @classmethod
    def empty(cls, joints: int) -> RowSpace:
        """The row space of no rows."""
        return cls(np.zeros(joints, dtype=bool), np.empty((0, joints)))

    def inverse(self, rows: Floats, size: float, damping: Damping) -> Inverse | Selected | None:
        """How to move rows by displacements outside of this space.

        Args:
            rows: shape (k, n).
            size: their Frobenius norm.
            damping: near singularities.

        Returns:
            ``None`` where nothing of the rows is left.
        """
        if not self.room:
            return None
        rows = self._in_free_joints(rows)
        selection = Selection.of(rows)
        selected = None if selection is None else self._select(rows, selection, damping)
        if selected is not None:
            left = np.count_nonzero(selected.joints) > len(selected.within)
            return selected if left else None
        rest = self._beside_basis(rows)
        inverse = from_gram_matrix(rest, size, damping) or self._carefully(rest, size, damping)
        return inverse if len(inverse.directions) else None

    def extended(self, inverse: Inverse | Selected) -> RowSpace:
        """The row space with inverted rows added."""
        if isinstance(inverse, Selected):
            return RowSpace(self._used | inverse.joints, inverse.beside)
        return RowSpace(self._used, _stacked(self._basis, inverse.directions))

    def singular_values(self, rows: Floats, size: float) -> Floats:
        """Of what this space leaves of rows (k, n), largest first, without those of rounding."""
        rest = self._beside_basis(self._in_free_joints(rows))
        values = np.linalg.svd(rest, full_matrices=False)[1][: self.room]
        above_rounding: Floats = values[values > ROUNDING * size]
        return above_rounding

    def _select(self, rows: Floats, selection: Selection, damping: Damping) -> Selected | None:
        """The inverse of a selection, if all its singular values are the same or 0.

        They are where the basis lies in the selected joints or in others, but not across.
        """
        joints, scales = selection
        sizes = {abs(scale) for scale in scales.tolist()} - {0.0}
        within, beside = _parts(self._basis, joints)
        if len(within) + len(beside) != len(self._basis) or (len(sizes) > 1 and len(within)):
            return None
        if not sizes or min(sizes) < damping.singular_value:
            return None
        if sizes != {1.0}:
            rows = rows / np.where(scales == 0.0, 1.0, scales * scales)[:, None]
        return Selected(rows, joints, within, beside)

    def _carefully(self, rest: Floats, size: float, damping: Damping) -> Inverse:
        left, values, right = np.linalg.svd(rest, full_matrices=False)
        rank = min(int(np.count_nonzero(values > ROUNDING * size)), self.room)
        # What was subtracted left rounding, which small singular values have magnified.
        directions = self._orthonormal(self._beside_basis(self._in_free_joints(right[:rank])))
        return from_singular_values(left[:, :rank], values[:rank], directions, damping)

    def _in_free_joints(self, rows: Floats) -> Floats:
        return rows if self._free is None else rows * self._free

    def _beside_basis(self, rows: Floats) -> Floats:
        """What is left of rows (k, n) at right angles to the basis."""
        if not len(self._basis):
            return rows
        # ``dot`` does the same as ``@`` in half the time where matrices are this small.
        beside: Floats = rows - rows.dot(self._basis.T).dot(self._basis)
        return beside

    def _orthonormal(self, directions: Floats) -> Floats:
        """Rows (k, n), nearly orthonormal, made so; at right angles to the basis as well."""
        above = len(self._basis)
        columns, triangle = np.linalg.qr(_stacked(self._basis, directions).T)
        signs = np.sign(np.diagonal(triangle)[above:])
        oriented: Floats = columns[:, above:].T * signs[:, None]
        return oriented


def _stacked(above: Floats, below: Floats) -> Floats:
    return np.concatenate((above, below)) if len(above) else below


def _parts(basis: Floats, joints: Booleans) -> tuple[Floats, Floats]:
    """The rows of a basis that lie in some joints, and those that lie in others."""
    numbers = np.count_nonzero(basis)
    inside = basis.compress(joints, axis=1)
    numbers_inside = np.count_nonzero(inside)
    if numbers_inside == numbers:
        return basis, basis[:0]
    if not numbers_inside:
        return basis[:0], basis
    touching = inside.any(axis=1)
    leaving = basis.compress(~joints, axis=1).any(axis=1)
    return basis[~leaving], basis[~touching]
