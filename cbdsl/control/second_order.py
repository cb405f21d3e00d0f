"""Second order of the control law: steps of levels that singularities restrict; compiled.

Model. A level requests a displacement v of its task coordinates x(q). In a tick it covers a
fraction f of the way to its target. Its error e is thus v / f, bounded as its speed is. Z are the
free directions of the levels above. If the Jacobian J within Z cannot achieve e, the part left = e
- J dq / f remains. Newton's step for half the square of the error then is

    (Z' J' J Z + S+) y = Z' J' v,   S = - sum_i left_i H_i + sum_j lambda_j H_j

with H_i the Hessians of the level's own coordinates, and H_j those of the levels above. The
multipliers lambda balance J' left on the levels above (the curvature of the manifold on which they
hold). S+ is the positive part of S, so that the step descends. Directions without any stiffness
keep the damping of first order. A direction that S+ resists is one in which the level is displaced
by the square of a step. It is withheld from the levels below, as the rows of J are. First-order
null spaces alone would let a lower level move along it, and the level above would move back: both
would oscillate for ever.

At a saddle of the error, such as an arm stretched away from its target, J' v vanishes and S has a
negative part: no step of first order helps. The level then takes a step d along the direction in
which J' J + S has the negative value m that gains most. Half the square of the error falls by p d +
|m| d^2 / 2, with the part p of J' e. The step is added if y gains less. It is as long as the
level's rows need for the request, the whole rows: the part that the levels above leave may be
short, and a step by that would be far longer and swing.

Source: the hierarchical Newton method of Pfeiffer, Escande, Gergondet and Kheddar (2023,
arXiv 2303.04428), with the displacement of one tick in place of the whole error.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.control.basis import Basis, gram_schmidt, project
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import add, copy, dot, norm, scale

# A level resists a direction if its curvature, relative to the remaining displacement, is above
# this, m or rad: far below a link's length, and far above the effect of an encoder's resolution.
RESISTED = 1e-3
# Multiple of it from which on a negative curvature is worth leaving: half a radian along it lowers
# the error by a hundredth of its unit, about the tolerance of an arrival. Less is a long creep.
_SADDLE = 100.0

# Added to squared singular values that multipliers are divided by. They grow at a singularity, and
# with them the stiffness of the levels below: bounded multipliers would let these swing.
_SOFT = 1e-10

# Curvature of a direction that is rounding, as a share of the largest one.
_ROUNDING = 1e-13

# Least divisor of a step, in the square of the Jacobians' unit.
_FLOOR = 1e-24


class Way(NamedTuple):
    """Way of a level to its target, in the unit of its coordinates.

    Attributes:
        requested: Length of the displacement that it requests in a tick.
        fraction: Share of the way that it requests.
        error: Length of the way; more than requested / fraction if bounds shorten the request.
        lever: Root of the mean square of the singular values of its whole rows.
    """

    requested: float
    fraction: float
    error: float
    lever: float


@compiled
def add_curvature(hessians: Floats, weights: Floats, factor: float, curvature: Floats) -> None:
    """Add weighted Hessians to a curvature.

    Args:
        hessians: Second derivatives of k task coordinates, shape (k, n, n).
        weights: Weights of the coordinates, shape (k,).
        factor: Common factor of the weights.
        curvature: Sum so far, shape (n, n).
    """
    for i in range(len(weights)):
        if weights[i] != 0.0:
            for joint in range(len(curvature)):
                add(curvature[joint], hessians[i, joint], factor * weights[i])


@compiled
def balance(pull: Floats, basis: Basis, count: int, rows: Floats) -> Floats:
    """Return the multipliers of the levels above that balance a pull of a level below.

    The basis makes the rows above block-triangular, so that back substitution solves for them.

    Args:
        pull: Generalised force of the lower level, shape (n,); becomes the unbalanced remainder.
        basis: Basis of the levels above.
        count: Number of directions that are taken.
        rows: Jacobian of all task coordinates, shape (K, n).
    """
    directions, sides = basis.directions, basis.sides
    multipliers = np.zeros(len(rows))
    i = count - 1
    while i >= 0:
        along, square, pin = dot(pull, directions[i]), dot(sides[i], sides[i]), basis.pins[i]
        if pin >= 0:
            part = directions[i, pin]
            pull[pin] -= along * part / (part * part + _SOFT)
        elif square > 0.0:
            along /= square + _SOFT
            add(multipliers, sides[i], along)
            for k in range(len(rows)):
                if sides[i, k] != 0.0:
                    add(pull, rows[k], -along * sides[i, k])
        i -= 1
    return multipliers


@compiled
def newton_step(
    curvature: Floats,
    basis: Floats,
    taken: int,
    values: Floats,
    along: Floats,
    guards: Floats,
    way: Way,
) -> tuple[Floats, Floats]:
    """Compute a level's Newton step in its free directions.

    Args:
        curvature: Symmetric curvature S, shape (n, n).
        basis: Orthonormal directions, shape (n, n): first those of the levels above, then those of
            the level's rows; those in which the error is curved are added.
        taken: Number of directions of the levels above.
        values: Singular values of the level's rows, shape (rank,).
        along: Requested displacement along each of them, shape (rank,).
        guards: Guards of the law.
        way: Way of the level to its target.

    Returns:
        The step, rad, shape (n,), and the resisted directions, as long as the square roots of their
        stiffness, shape (r, n).
    """
    least = least_resisted(way)
    rank = len(values) + _span_curvature(curvature, basis, taken + len(values))
    free, damping, threshold = basis[taken : taken + rank], guards[0], guards[1]
    size = len(free)
    positive, lowest, resisted = _positive_part(_restrict(curvature, free), free, least)
    for i in range(len(values)):
        positive[i, i] += values[i] * values[i]
    vectors = np.empty((size, size))
    diagonalize(positive, vectors)
    change, gained = np.zeros(free.shape[1]), 0.0
    for i in range(size):
        stiffness, pull = max(positive[i, i], 0.0), 0.0
        for j in range(len(values)):
            pull += vectors[i, j] * values[j] * along[j]
        weight = max(0.0, 1.0 - stiffness / (threshold * threshold))
        step = pull / max(stiffness + damping * weight, _FLOOR)
        gained += pull * step
        for j in range(size):
            add(change, free[j], step * vectors[i, j])
    last = len(resisted) - 1
    if way.requested == 0.0 or not lowest < -_SADDLE * least:
        return change, resisted[:last]
    inner = _restrict(curvature, free)
    for i in range(size):
        scale(inner[i], _whole(way) * way.fraction / way.requested)
    for i in range(len(values)):
        inner[i, i] += values[i] * values[i]
    away = _leave_saddle(inner, values, along, threshold, way, gained)
    if not norm(away) > 0.0:
        return change, resisted[:last]
    for j in range(size):
        add(change, free[j], away[j])
        add(resisted[last], free[j], away[j] / norm(away) * math.sqrt(-lowest))
    return change, resisted


@compiled
def _leave_saddle(
    inner: Floats, values: Floats, along: Floats, threshold: float, way: Way, gained: float
) -> Floats:
    """Return a step down the curvature of an error, or zero if the ordinary step gains more.

    Args:
        inner: Curvature J' J + S of the error in the free directions, shape (m, m); is overwritten.
        values: Singular values of the level's rows, shape (rank,).
        along: Requested displacement along each of them, shape (rank,).
        threshold: Least divisor of the request, in the unit of the rows.
        way: Way of the level to its target.
        gained: Product of the pull with the ordinary step.
    """
    size, longest = len(inner), max(way.lever, threshold)
    for i in range(len(values)):
        longest = max(longest, values[i])
    length, per_pull = way.requested / longest, _whole(way) / way.requested
    vectors, away, most = np.empty((size, size)), np.zeros(size), gained * per_pull
    diagonalize(inner, vectors)
    for i in range(size):
        pull, largest = 0.0, 0
        for j in range(size):
            if j < len(values):
                pull += vectors[i, j] * values[j] * along[j]
            if abs(vectors[i, j]) > abs(vectors[i, largest]) + 1e-9:
                largest = j
        gain = abs(pull) * length * per_pull - 0.5 * inner[i, i] * length * length
        if inner[i, i] < 0.0 and gain > most:
            most = gain
            # Without a pull, both ways lead down: the largest component decides.
            side = pull if abs(pull) > 1e-15 else vectors[i, largest]
            copy(away, vectors[i], math.copysign(length, side))
    return away


@compiled
def _span_curvature(curvature: Floats, basis: Floats, taken: int) -> int:
    """Add the directions that a curvature bends to a basis; return their number.

    The step has no part along others: they have neither stiffness nor a request.

    Args:
        curvature: Symmetric curvature, shape (n, n).
        basis: Orthonormal directions, shape (n, n).
        taken: Number of directions in the basis so far.
    """
    rest, count, largest = np.empty(curvature.shape), 0, 0.0
    for row in curvature:
        length = norm(row)
        if length > 0.0:
            copy(rest[count], row, 1.0)
            project(rest, count, basis, taken)
            largest = max(largest, length)
            count += 1
    return len(gram_schmidt(rest[:count], basis, taken, _ROUNDING * largest, count))


@compiled
def least_resisted(way: Way) -> float:
    """Return the stiffness above which a level resists a direction."""
    return RESISTED * way.requested / way.fraction + 1e-15


@compiled
def _whole(way: Way) -> float:
    """Return the length of a way; a level that searches knows only the way that it requests."""
    bounded = way.requested / way.fraction
    return way.error if way.error > bounded else bounded


@compiled
def _restrict(matrix: Floats, free: Floats) -> Floats:
    """Return a symmetric matrix (n, n) in some orthonormal directions (m, n), shape (m, m)."""
    size = len(free)
    inner, image = np.empty((size, size)), np.empty(len(matrix))
    for i in range(size):
        for joint in range(len(matrix)):
            image[joint] = dot(matrix[joint], free[i])
        for j in range(i + 1):
            inner[i, j] = inner[j, i] = dot(free[j], image)
    return inner


@compiled
def _positive_part(inner: Floats, free: Floats, least: float) -> tuple[Floats, float, Floats]:
    """Return the positive part of a matrix (m, m), its lowest eigenvalue, and resisted directions.

    The directions have shape (r + 1, n), the last one of them 0.
    """
    size = len(inner)
    vectors, positive, lowest = np.empty((size, size)), np.zeros((size, size)), 0.0
    resisted, count = np.zeros((size + 1, free.shape[1])), 0
    diagonalize(inner, vectors)
    for i in range(size):
        stiffness = inner[i, i]
        lowest = min(lowest, stiffness)
        if stiffness <= 0.0:
            continue
        for j in range(size):
            for k in range(size):
                positive[j, k] += stiffness * vectors[i, j] * vectors[i, k]
        if stiffness > 0.5 * least:
            for j in range(size):
                add(resisted[count], free[j], math.sqrt(stiffness) * vectors[i, j])
            count += 1
    return positive, lowest, resisted[: count + 1]


# Sweeps converge quadratically; further ones do not reduce rounding errors.
_SWEEPS = 12

# Elements count as zero at this share of the diagonal elements beside them.
_ZERO = 1e-15


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
                if abs(matrix[i, j]) > _ZERO * scale:
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
