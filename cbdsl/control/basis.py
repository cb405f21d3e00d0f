"""Orthonormal basis of the joint directions that levels of a stack take; compiled.

The basis gives an exact projector for all ranks and conditions of the rows; I - J^# J does not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.numeric.compiled import compiled, compiled_sum
from cbdsl.numeric.vector import add, copy, dot, fill, norm

# Rows count as dependent if their remainder is rounding of the Jacobian. Lower levels would be free
# to disturb rows that a larger tolerance ignores.
_ROUNDING = 1e-13

# Rows count as orthogonal at this cosine of their angle.
_ORTHOGONAL = 1e-14

# A few sweeps make rows orthogonal, with quadratic convergence. Rounding may keep two of them
# beyond the cosine above; further sweeps do not help.
_SWEEPS = 20


class Basis(NamedTuple):
    """Joint directions that are taken, in the order of priority.

    Attributes:
        directions: Orthonormal directions, shape (n, n); the first ones are taken.
        sides: Parts of all task rows in each direction, shape (n, k).
        pins: Joint that each direction stands for because it is locked, or -1, shape (n,).
    """

    directions: Floats
    sides: Floats
    pins: Integers


@compiled
def empty_basis(joints: int, rows: int) -> Basis:
    """Return a basis without directions for a number of joints and of task rows."""
    return Basis(np.empty((joints, joints)), np.zeros((joints, rows)), np.full(joints, -1))


@compiled
def span(rows: Floats, basis: Basis, taken: int, start: int, values: Floats) -> Floats:
    """Add the directions of a level's rows at right angles to the first ``taken`` ones.

    A displacement at right angles to the basis does not affect the levels above.

    Args:
        rows: Jacobian of the level, shape (k, n).
        basis: Basis of the levels above.
        taken: Number of its directions.
        start: Number of the level's first row among all task rows.
        values: Become the singular values, unsorted, shape (k,); 0 for dependent rows.

    Returns:
        The rows' parts in the level's directions, orthogonal, shape (rank, k).
    """
    directions, sides = basis.directions, basis.sides
    rest, squares = np.empty(rows.shape), 0.0
    for i in range(len(rows)):
        copy(rest[i], rows[i], 1.0)
        squares += dot(rows[i], rows[i])
        project(rest, i, directions, taken)
    parts = gram_schmidt(rest, directions, taken, _ROUNDING * math.sqrt(squares), len(rest))
    jacobi_svd(parts, directions[taken : taken + len(parts)])
    fill(values, 0.0)
    for i in range(len(parts)):
        values[i] = norm(parts[i])
        for k in range(len(rows)):
            sides[taken + i, start + k] = parts[i, k]
        basis.pins[taken + i] = -1
    return parts


@compiled
def resist(resisted: Floats, basis: Basis, taken: int, least: float, before: int) -> int:
    """Add resisted directions to the basis; return its number of directions.

    A direction begins to count at twice the ``least`` stiffness and ceases at half of it. The noise
    of sensors therefore does not open and close it to lower levels.

    Args:
        resisted: Directions, as long as the square roots of their stiffness, shape (r, n).
        basis: Basis so far.
        taken: Number of its directions.
        least: Stiffness above which a direction counts as resisted.
        before: Number of resisted directions in the preceding tick.
    """
    directions, more = basis.directions, taken
    for i in range(len(resisted)):
        project(resisted, i, directions, taken)
    for stiffness, most in ((0.5 * least, before), (2.0 * least, len(resisted))):
        count = min(most - (more - taken), len(resisted))
        if count > 0:
            more += len(gram_schmidt(resisted, directions, more, math.sqrt(stiffness), count))
    for i in range(taken, more):
        fill(basis.sides[i], 0.0)
        basis.pins[i] = -1
    return more


@compiled
def pin_joints(locked: Booleans, basis: Basis, taken: int) -> int:
    """Add the locked joints to the basis; return its number of directions."""
    directions = basis.directions
    for i in range(taken, len(directions)):
        fill(basis.sides[i], 0.0)
    for joint in range(len(locked)):
        if locked[joint] and taken < len(directions):
            fill(directions[taken], 0.0)
            directions[taken, joint] = 1.0
            project(directions, taken, directions, taken)
            if norm(directions[taken]) > _ROUNDING:
                _orthonormalize(directions, taken)
                basis.pins[taken] = joint
                taken += 1
    return taken


@compiled
def gram_schmidt(rest: Floats, basis: Floats, taken: int, least: float, most: int) -> Floats:
    """Add orthonormal directions that span the rows to a basis, and subtract them from the rows.

    Gram-Schmidt orthogonalisation, longest row first, down to rows no longer than ``least``, for at
    most ``most`` directions.

    Returns:
        The rows' parts in these directions, shape (rank, k).
    """
    parts = np.empty((min(most, len(basis) - taken), len(rest)))
    for rank in range(len(parts)):
        longest, size = 0, 0.0
        for i in range(len(rest)):
            length = norm(rest[i])
            if length > size:
                longest, size = i, length
        if size <= least:
            return parts[:rank]
        direction = basis[taken + rank]
        copy(direction, rest[longest], 1.0)
        _orthonormalize(basis, taken + rank)
        for i in range(len(rest)):
            parts[rank, i] = dot(rest[i], direction)
            add(rest[i], direction, -parts[rank, i])
    return parts


@compiled
def jacobi_svd(parts: Floats, directions: Floats) -> None:
    """Turn rows until they are orthogonal, together with directions (one-sided Jacobi).

    The lengths of the rows are then their singular values, and small ones are as precise as large
    ones.
    """
    for _ in range(_SWEEPS):
        turned = False
        for i in range(len(parts) - 1):
            for j in range(i + 1, len(parts)):
                turned |= _turn(parts, directions, i, j)
        if not turned:
            break


@compiled
def _turn(parts: Floats, directions: Floats, i: int, j: int) -> bool:
    """Turn two rows until they are orthogonal; return whether they were not."""
    first = second = both = 0.0
    for k in range(parts.shape[1]):
        one, other = parts[i, k], parts[j, k]
        first += one * one
        second += other * other
        both += one * other
    if abs(both) <= _ORTHOGONAL * math.sqrt(first) * math.sqrt(second):
        return False
    ratio = (second - first) / (2.0 * both)
    tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    for rows in (parts, directions):
        for k in range(rows.shape[1]):
            one, other = cosine * rows[i, k], cosine * rows[j, k]
            rows[i, k], rows[j, k] = one - tangent * other, tangent * one + other
    return True


@compiled_sum
def project(rows: Floats, place: int, basis: Floats, count: int) -> None:
    """Make a row orthogonal to the first ``count`` of the basis."""
    for i in range(count):
        along = 0.0
        for joint in range(rows.shape[1]):
            along += rows[place, joint] * basis[i, joint]
        for joint in range(rows.shape[1]):
            rows[place, joint] -= along * basis[i, joint]


@compiled
def _orthonormalize(basis: Floats, last: int) -> None:
    """Make row ``last``, nearly orthogonal to those above it, orthonormal to them.

    The earlier subtraction left rounding errors, which the division by the row's length magnifies.
    """
    copy(basis[last], basis[last], 1.0 / norm(basis[last]))
    project(basis, last, basis, last)
    copy(basis[last], basis[last], 1.0 / norm(basis[last]))
