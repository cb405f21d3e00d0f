"""Arithmetic of the control law, for all levels together; compiled.

Model. A level has rows J (k, n) and a requested displacement v. B is an orthonormal basis of all
rows above, and D the displacement composed so far. With P = I - B B', the level adds

    d = (J P)^# (v - J D)

by the singular values of J P, damped where one is small. Then B grows by its directions. A level
that cannot achieve v takes Newton's step instead (``second_order``). A joint that d would push past
a limit joins B at its limit, and the level is solved again. A step that exceeds a joint's speed is
shortened as a whole.

Assumption: rows change by little in a tick. Those of its middle are extrapolated from three ticks.
Source: Eq 3.23 to 3.26 of the dissertation, with a basis in place of I - J^# J, which leaks where
J^# is damped. Loops are compiled because calling numpy on a dozen numbers takes longer.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.level import LevelArrays
from cbdsl.control.second_order import (
    add_curvature,
    balance,
    least_resisted,
    newton_step,
)
from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.numeric.compiled import compiled, compiled_once, compiled_sum
from cbdsl.numeric.vector import add, copy, dot, fill, norm, scale

# Rows count as dependent if their remainder is rounding of the Jacobian. Lower levels would be free
# to disturb rows that a larger tolerance ignores.
_ROUNDING = 1e-13

# Rows count as orthogonal at this cosine of their angle.
_ORTHOGONAL = 1e-14

# A few sweeps make rows orthogonal, with quadratic convergence. Rounding may keep two of them
# beyond the cosine above; further sweeps do not help.
_SWEEPS = 20

# Multiple of the damping's threshold below which a singular value may need the second order.
_NEAR_SINGULAR = 5.0

# Share of a residual that counts as achieved if less than this is left of it.
_ACHIEVED = 1e-9

# Bounds are this much wider, rad, so that rounding never counts as passing one.
_SLACK = 1e-12


@compiled_once
def compose(
    positions: Floats,
    newest: int,
    levels: LevelArrays,
    bends: bool,
    limits: Floats,
    steps: Floats,
    guards: Floats,
    total: Floats,
    locked: Booleans,
    values: Floats,
) -> bool:
    """Compose the displacement of all levels.

    Args:
        positions: Joint positions, rad, shape (n,).
        newest: Number of this tick among three; the tick before is one less, modulo 3.
        levels: Levels, highest priority first.
        bends: True if the levels' Hessians are those of this tick.
        limits: Lower and upper limits, rad, shape (2, n); may be infinite.
        steps: Largest displacement of each joint, rad, shape (n,).
        guards: Largest damping in the square of the Jacobians' unit, and the singular value below
            which damping sets in.
        total: Becomes the displacement, NaN if an argument is not finite, shape (n,).
        locked: Becomes True for joints that a limit held back, shape (n,).
        values: Become the singular values of the rows that were left to each level, unsorted, shape
            (k,); 0 for dependent rows and inactive levels.

    Returns:
        True if a level needs Hessians and ``bends`` is False; the displacement is then unfinished.
    """
    rows, ages, wanted, ends = levels.rows, levels.ages, levels.requested, levels.ends
    fractions, curved, damping, threshold = levels.fractions, levels.curved, guards[0], guards[1]
    joints = rows.shape[2]
    fill(total, 0.0)
    fill(values, 0.0)
    for joint in range(joints):
        locked[joint] = False
    middle = np.empty(rows.shape[1:])
    if not _prepare(positions, newest, rows, ages, wanted, ends, bends, middle):
        fill(total, math.nan)
        return False
    bounds = _bounds(positions, limits, steps)
    basis, taken = np.empty((joints, joints)), 0
    sides, pins, along = np.zeros((joints, len(wanted))), np.full(joints, -1), np.empty(joints)
    start, delicate, second = 0, False, curved.any()
    for level in range(len(ends)):
        end = ends[level]
        # Every pass locks a joint or is the last.
        while taken < joints and ages[level] > 0:
            own, sizes = middle[start:end], values[start:end]
            residual = _task_residual(own, wanted[start:end], total)
            change, below = _invert(
                own, residual, basis, taken, sizes, along, sides[:, start:end], damping, threshold
            )
            rank = below - taken
            _unpin(pins, taken, below)
            singular = _is_singular(sizes[:rank], end - start, curved[level], threshold)
            resisted = basis[:0]
            least = least_resisted(norm(wanted[start:end]), fractions[level])
            if second and (delicate or singular or _is_near(sizes[:rank], threshold)):
                left = _undone(own, residual, change, total, locked, bounds, steps)
                if delicate or singular or norm(left) > _ACHIEVED * norm(residual):
                    if not bends:
                        return True
                    scale(left, 1.0 / fractions[level])
                    resisted = newton_step(
                        _curve(left, basis, taken, sides, pins, middle, start, levels.hessians),
                        basis, taken, below, sizes[:rank], along[:rank], guards, least, change,
                    )  # fmt: skip
            _shorten(change, total, locked, bounds, steps)
            if not _lock(change, total, locked, bounds):
                add(total, change, 1.0)
                delicate |= singular
                taken = _resist(resisted, basis, below, sides, pins, least, levels, level)
                break
            taken = _lock_joints(locked, basis, taken, sides, pins)
        start = end
    for joint in range(joints):
        total[joint] = min(max(total[joint], bounds[0, joint]), bounds[1, joint])
    return False


@compiled
def _unpin(pins: Integers, first: int, last: int) -> None:
    """Note that directions stand for no joint."""
    for i in range(first, last):
        pins[i] = -1


@compiled
def _prepare(
    positions: Floats,
    newest: int,
    rows: Floats,
    ages: Integers,
    wanted: Floats,
    ends: Integers,
    bends: bool,
    middle: Floats,
) -> bool:
    """Write the rows of active levels; return whether all numbers are finite.

    They are those of the middle of the tick, or of its start if Hessians say how they change: at a
    singularity, extrapolation enlarges each alternation of the rows up to 3.5 times.
    """
    squares = dot(positions, positions)
    start = 0
    for level in range(len(ends)):
        end = ends[level]
        for row in range(start, end):
            fill(middle[row], 0.0)
        if ages[level] > 0:
            _extrapolate(rows, newest, 1 if bends else ages[level], start, end, middle)
            for row in range(start, end):
                squares += dot(middle[row], middle[row]) + wanted[row] * wanted[row]
        start = end
    return math.isfinite(squares)


@compiled
def _is_singular(values: Floats, count: int, curved: bool, threshold: float) -> bool:
    """Return whether singular values keep a level from achieving all displacements."""
    if len(values) > 0 and values.min() < threshold:
        return True
    return curved and len(values) < count


@compiled
def _is_near(values: Floats, threshold: float) -> bool:
    """Return whether bounds may leave part of a level undone because a singularity is near."""
    return len(values) > 0 and values.min() < _NEAR_SINGULAR * threshold


@compiled
def _undone(
    own: Floats,
    residual: Floats,
    change: Floats,
    total: Floats,
    locked: Booleans,
    bounds: Floats,
    steps: Floats,
) -> Floats:
    """Return the part of a residual (k,) that a change leaves undone within the joints' bounds."""
    trial, left = change.copy(), np.empty(len(own))
    _shorten(trial, total, locked, bounds, steps)
    for i in range(len(own)):
        left[i] = residual[i] - dot(own[i], trial)
    return left


@compiled
def _curve(
    left: Floats,
    basis: Floats,
    taken: int,
    sides: Floats,
    pins: Integers,
    middle: Floats,
    start: int,
    hessians: Floats,
) -> Floats:
    """Return the curvature (n, n) of the error (k,) that a level's step leaves undone."""
    joints, end = len(basis), start + len(left)
    curvature, pull = np.zeros((joints, joints)), np.zeros(joints)
    add_curvature(hessians[start:end], left, -1.0, curvature)
    if taken > 0:
        for i in range(len(left)):
            add(pull, middle[start + i], left[i])
        multipliers = balance(pull, basis, sides, pins, taken, middle)
        add_curvature(hessians[:start], multipliers[:start], 1.0, curvature)
    return curvature


@compiled
def _resist(
    resisted: Floats,
    basis: Floats,
    taken: int,
    sides: Floats,
    pins: Integers,
    least: float,
    levels: LevelArrays,
    level: int,
) -> int:
    """Add resisted directions to the basis; return its number of rows.

    A direction begins to count at twice the ``least`` stiffness and ceases at half of it. The noise
    of sensors therefore does not open and close it to lower levels.
    """
    before = levels.withheld[level] if levels.ages[level] > 1 else 0
    for i in range(len(resisted)):
        _project(resisted, i, basis, taken)
    more = taken
    for stiffness, most in ((0.5 * least, before), (2.0 * least, len(resisted))):
        count = min(most - (more - taken), len(resisted))
        if count > 0:
            more += len(_gram_schmidt(resisted, basis, more, math.sqrt(stiffness), count))
    for i in range(taken, more):
        fill(sides[i], 0.0)
    _unpin(pins, taken, more)
    levels.withheld[level] = more - taken
    return more


@compiled_once
def extrapolate_half_tick(rows: Floats, newest: int, ages: Integers, ends: Integers) -> Floats:
    """Return rows half a tick ahead, shape (k, n), 0 for levels that do not act."""
    middle = np.zeros(rows.shape[1:])
    start = 0
    for level in range(len(ends)):
        end = ends[level]
        if ages[level] > 0:
            _extrapolate(rows, newest, ages[level], start, end, middle)
        start = end
    return middle


@compiled
def _extrapolate(rows: Floats, newest: int, age: int, start: int, end: int, middle: Floats) -> None:
    """Extrapolate half a tick ahead from up to three ticks: parabola, line or constant."""
    now, before, earlier = rows[newest], rows[newest - 1], rows[newest - 2]
    for row in range(start, end):
        for joint in range(rows.shape[2]):
            middle[row, joint] = now[row, joint]
            if age == 2:
                middle[row, joint] += 0.5 * (now[row, joint] - before[row, joint])
            elif age > 2:
                middle[row, joint] += (
                    0.875 * now[row, joint]
                    - 1.25 * before[row, joint]
                    + 0.375 * earlier[row, joint]
                )


@compiled
def _bounds(positions: Floats, limits: Floats, steps: Floats) -> Floats:
    """Return the least and the largest displacement of each joint, shape (2, n).

    Limits take precedence over the levels' requests, and the largest step over limits.
    """
    bounds = np.empty(limits.shape)
    for joint in range(len(positions)):
        step = steps[joint]
        lowest = limits[0, joint] - positions[joint] - _SLACK
        highest = limits[1, joint] - positions[joint] + _SLACK
        bounds[0, joint] = max(min(lowest, step), -step - 2 * _SLACK)
        bounds[1, joint] = min(max(highest, -step), step + 2 * _SLACK)
    return bounds


@compiled
def _shorten(
    change: Floats, total: Floats, locked: Booleans, bounds: Floats, steps: Floats
) -> None:
    """Shorten a change as a whole so that every joint keeps within its largest step."""
    share, exceeds = 1.0, False
    for joint in range(len(change)):
        if locked[joint]:
            change[joint] = 0.0  # exact, because rounding could look like passing a bound
        target = total[joint] + change[joint]
        exceeds |= target < bounds[0, joint] or target > bounds[1, joint]
        size = abs(change[joint])
        ahead = total[joint] if change[joint] > 0.0 else -total[joint]
        left = max(steps[joint] + _SLACK - ahead, 0.0)
        if size > left + _SLACK:
            share = min(share, left / size)
    if exceeds:
        for joint in range(len(change)):
            change[joint] *= share


@compiled
def _lock(change: Floats, total: Floats, locked: Booleans, bounds: Floats) -> bool:
    """Lock joints that would pass a bound, at their position or on their way back inside."""
    passes = False
    for joint in range(len(change)):
        target = total[joint] + change[joint]
        if target < bounds[0, joint] or target > bounds[1, joint]:
            passes = locked[joint] = True
            total[joint] = min(max(total[joint], bounds[0, joint]), bounds[1, joint])
    return passes


@compiled
def _lock_joints(locked: Booleans, basis: Floats, taken: int, sides: Floats, pins: Integers) -> int:
    """Add the locked joints to the basis; return its number of rows."""
    for i in range(taken, len(basis)):
        fill(sides[i], 0.0)
    for joint in range(len(locked)):
        if locked[joint] and taken < len(basis):
            for column in range(len(locked)):
                basis[taken, column] = 1.0 if column == joint else 0.0
            _project(basis, taken, basis, taken)
            if norm(basis[taken]) > _ROUNDING:
                _orthonormalize(basis, taken)
                pins[taken] = joint
                taken += 1
    return taken


@compiled
def _task_residual(rows: Floats, wanted: Floats, total: Floats) -> Floats:
    """Return the part of the rows' requested displacement (k,) that is not yet composed."""
    residual = np.empty(len(wanted))
    for i in range(len(wanted)):
        residual[i] = wanted[i] - dot(rows[i], total)
    return residual


@compiled
def _invert(
    rows: Floats,
    velocity: Floats,
    basis: Floats,
    taken: int,
    values: Floats,
    alongs: Floats,
    sides: Floats,
    damping: float,
    threshold: float,
) -> tuple[Floats, int]:
    """Move rows by ``velocity`` at right angles to the first ``taken`` rows of the basis.

    A displacement at right angles to the basis does not affect the levels above. The basis gives an
    exact projector for all ranks and conditions of the rows; I - J^# J does not.

    Returns:
        The displacement, damped along small singular values, shape (n,); the basis' number of rows
        with the level's directions.
    """
    rest, squares = np.empty(rows.shape), 0.0
    for i in range(len(rows)):
        copy(rest[i], rows[i], 1.0)
        squares += dot(rows[i], rows[i])
        _project(rest, i, basis, taken)
    parts = _gram_schmidt(rest, basis, taken, _ROUNDING * math.sqrt(squares), len(rest))
    directions = basis[taken : taken + len(parts)]
    jacobi_svd(parts, directions)
    change = np.empty(rows.shape[1])
    fill(change, 0.0)
    fill(values, 0.0)
    for i in range(len(parts)):
        values[i] = norm(parts[i])
        alongs[i] = dot(parts[i], velocity) / values[i]
        add(change, directions[i], alongs[i] * _damped_inverse(values[i], damping, threshold))
        copy(sides[taken + i], parts[i], 1.0)
    return change, taken + len(parts)


@compiled
def _gram_schmidt(rest: Floats, basis: Floats, taken: int, least: float, most: int) -> Floats:
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


@compiled
def _damped_inverse(value: float, damping: float, threshold: float) -> float:
    """Return the damped inverse of a singular value (Levenberg-Marquardt).

    The damping grows from 0 at ``threshold`` to ``damping`` at 0. Steps thus stay bounded and
    continuous through singularities, and are exact away from them.
    """
    weight = max(0.0, 1.0 - (value / threshold) ** 2)
    return value / (value * value + damping * weight)


@compiled_sum
def _project(rows: Floats, place: int, basis: Floats, count: int) -> None:
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
    _project(basis, last, basis, last)
    copy(basis[last], basis[last], 1.0 / norm(basis[last]))
