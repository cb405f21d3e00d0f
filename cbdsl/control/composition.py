"""Arithmetic of the control law, for all levels together; compiled.

Model. A level has rows J (k, n) and a requested displacement v. B is an orthonormal basis of all
rows above, and D the displacement composed so far. With P = I - B B', the level adds

    d = (J P)^# (v - J D)

by the singular values of J P, damped where one is small. Then B grows by its directions. A level
that cannot achieve v takes Newton's step instead (``second_order``). D grows by d up to the first
limit of a joint or bound of a row (``row_bounds``) that d would pass. The joint or row joins B
there, and the level is solved again. A step that exceeds a joint's speed is shortened as a whole.

Assumption: rows change by little in a tick. Those of its middle are extrapolated from three ticks.
Source: Eq 3.23 to 3.26 of the dissertation, with a basis in place of I - J^# J, which leaks where
J^# is damped. Loops are compiled because calling numpy on a dozen numbers takes longer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.control.basis import Basis, empty_basis, pin_joints, resist, span
from cbdsl.control.half_tick import write_middle
from cbdsl.control.joint_bounds import displacement_bounds, go, keep_within, shorten
from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.level import LevelArrays
from cbdsl.control.row_bounds import hold_row, leave_idle, next_bound
from cbdsl.control.second_order import Way, add_curvature, balance, least_resisted, newton_step
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.handle import Handle
from cbdsl.numeric.vector import add, dot, fill, norm, scale

# Multiple of the damping's threshold below which a singular value may need the second order.
_NEAR_SINGULAR = 5.0

# Share of a residual that counts as achieved if less than this is left of it.
_ACHIEVED = 1e-9


class ComposedArrays(NamedTuple):
    """Levels of a stack, and the law that composes them."""

    levels: LevelArrays
    law: LawArrays


@compiled_once
def compose_held(arrays: Handle, positions: Floats, bends: bool) -> bool:
    """Compose the displacement of all levels, for calls from Python; see ``compose``."""
    held: ComposedArrays = arrays.held
    return compose(positions, held.levels, bends, held.law)


@compiled
def compose(positions: Floats, levels: LevelArrays, bends: bool, law: LawArrays) -> bool:
    """Compose the displacement of all levels.

    Args:
        positions: Joint positions, rad, shape (n,).
        levels: Levels, highest priority first.
        bends: True if the levels' Hessians are those of this tick.
        law: Bounds and guards; its result is overwritten.

    Returns:
        True if a level needs Hessians and ``bends`` is False; the displacement is then unfinished.
    """
    ages, total, middle = levels.ages, law.displacement, np.empty(levels.rows.shape[1:])
    _clear(law, levels)
    if not write_middle(positions, levels, bends, middle):
        fill(total, math.nan)
        return False
    joints, bounds = len(total), displacement_bounds(positions, law)
    rows, wanted = middle.copy(), levels.requested.copy()
    basis, taken = empty_basis(joints, len(middle)), 0
    start, delicate, second = 0, False, levels.curved.any()
    for level, end in enumerate(levels.ends):
        acting = leave_idle(levels, level, start, total, middle, wanted)
        way = _way(level, levels, wanted[start:end], middle[start:end], acting)
        # Every pass locks a joint, reaches a bound or is the last.
        while taken < joints and ages[level] > 0:
            own, requested = middle[start:end], wanted[start:end]
            sizes = law.singular_values[start:end]
            residual = _task_residual(own, requested, total)
            parts = span(own, basis, taken, start, sizes)
            rank, along = len(parts), np.empty(len(parts))
            change = _damped_step(
                parts, residual, basis.directions[taken:], sizes, along, law.guards
            )
            below, resisted = taken + rank, basis.directions[:0]
            values, threshold = sizes[:rank], law.guards[1]
            singular = _is_singular(values, acting, levels.curved[level], threshold)
            if second and (delicate or singular or _is_near(values, threshold)):
                left = _undone(own, residual, change, law, bounds)
                if delicate or singular or norm(left) > _ACHIEVED * norm(residual):
                    levels.bent[0] = True
                    if not bends:
                        return True
                    curvature = _curve(left, way, basis, taken, middle, start, levels.hessians)
                    change, resisted = newton_step(
                        curvature, basis.directions, taken, values, along, law.guards, way
                    )
            shorten(change, law, bounds)
            reached, share = next_bound(levels, end, rows, total, change)
            if go(change, share, law, bounds):
                taken = pin_joints(law.locked, basis, taken)
                continue
            if reached < 0:
                delicate |= singular
                taken = _withhold(level, levels, resisted, basis, below, least_resisted(way))
                break
            taken = hold_row(reached, rows, levels, basis, taken, middle, wanted, law)
        start = end
    keep_within(total, bounds)
    return False


@compiled
def _withhold(
    level: int, levels: LevelArrays, resisted: Floats, basis: Basis, taken: int, least: float
) -> int:
    """Withhold directions that a level resists; return the basis' number of directions."""
    before = levels.withheld[level] if levels.ages[level] > 1 else 0
    more = resist(resisted, basis, taken, least, before)
    levels.withheld[level] = more - taken
    return more


@compiled
def _clear(law: LawArrays, levels: LevelArrays) -> None:
    """Clear the result of the last tick."""
    levels.bent[0] = False
    levels.idle[:] = False
    fill(law.displacement, 0.0)
    fill(law.singular_values, 0.0)
    for joint in range(len(law.locked)):
        law.locked[joint] = False


@compiled
def _damped_step(
    parts: Floats,
    residual: Floats,
    directions: Floats,
    values: Floats,
    along: Floats,
    guards: Floats,
) -> Floats:
    """Return the step of first order (n,), damped along small singular values.

    Args:
        parts: Parts of the level's rows in its directions, shape (rank, k).
        residual: Requested displacement that is not yet composed, shape (k,).
        directions: Directions of the level, shape (rank or more, n).
        values: Singular values, shape (rank or more,).
        along: Becomes the requested displacement along each direction, shape (rank,).
        guards: Guards of the law.
    """
    change = np.zeros(directions.shape[1])
    for i in range(len(parts)):
        along[i] = dot(parts[i], residual) / values[i]
        add(change, directions[i], along[i] * _damped_inverse(values[i], guards[0], guards[1]))
    return change


@compiled
def _damped_inverse(value: float, damping: float, threshold: float) -> float:
    """Return the damped inverse of a singular value (Levenberg-Marquardt).

    The damping grows from 0 at ``threshold`` to ``damping`` at 0. Steps thus stay bounded and
    continuous through singularities, and are exact away from them.
    """
    weight = max(0.0, 1.0 - (value / threshold) ** 2)
    return value / (value * value + damping * weight)


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
    own: Floats, residual: Floats, change: Floats, law: LawArrays, bounds: Floats
) -> Floats:
    """Return the part of a residual (k,) that a change leaves undone within the joints' bounds."""
    trial, left = change.copy(), np.empty(len(own))
    shorten(trial, law, bounds)
    for i in range(len(own)):
        left[i] = residual[i] - dot(own[i], trial)
    return left


@compiled
def _curve(
    left: Floats, way: Way, basis: Basis, taken: int, middle: Floats, start: int, hessians: Floats
) -> Floats:
    """Return the curvature (n, n) of the error that a level's step leaves undone, shape (k,)."""
    scale(left, 1.0 / way.fraction)
    joints, end = middle.shape[1], start + len(left)
    curvature, pull = np.zeros((joints, joints)), np.zeros(joints)
    add_curvature(hessians[start:end], left, -1.0, curvature)
    if taken > 0:
        for i in range(len(left)):
            add(pull, middle[start + i], left[i])
        # Own rows have multipliers where their bounds are reached.
        multipliers = balance(pull, basis, taken, middle)
        add_curvature(hessians[:end], multipliers[:end], 1.0, curvature)
    return curvature


@compiled
def _way(level: int, levels: LevelArrays, requested: Floats, rows: Floats, acting: int) -> Way:
    """Return the way of a level by its rows (k, n); idle rows are 0."""
    square = 0.0
    for row in rows:
        square += dot(row, row)
    lever = math.sqrt(square / max(acting, 1))
    return Way(norm(requested), levels.fractions[level], levels.errors[level], lever)


@compiled
def _task_residual(rows: Floats, wanted: Floats, total: Floats) -> Floats:
    """Return the part of the rows' requested displacement (k,) that is not yet composed."""
    residual = np.empty(len(wanted))
    for i in range(len(wanted)):
        residual[i] = wanted[i] - dot(rows[i], total)
    return residual
