"""Level of a slot in a tick: its potential, evaluated and bounded; compiled."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cbdsl.control.conditions.rate import brake_before, displace
from cbdsl.control.potential import Rule, call_at
from cbdsl.control.slot import TRACK
from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import copy, dot, fill, norm, scale
from cbdsl.sensing.signal_arrays import TableArrays

# Largest growth of a stride in a tick, and its smallest factor.
_LONGER, _SHORTEST = 1.05, 0.2

_DESCENT, _RESIDUAL = int(Rule.DESCENT), int(Rule.RESIDUAL)


class TaskArrays(NamedTuple):
    """Task coordinates of a slot in this tick and the preceding one.

    Attributes:
        columns: Joint index of each of the stack's n joints, -1 for joints that count as still.
        level: Becomes the task coordinates per joint, shape (k, n).
        last: Level of the preceding tick, shape (k, n).
        before: Displacement of the task coordinates in the preceding tick, shape (k,); becomes this
            tick's.
        steps: Steps of the joints' encoders, rad or m, shape (n,).
        sides: Become the sides of bounds that hold, otherwise 0, shape (k,).
        room: Become the ways to these bounds, in the slot's unit, shape (k,).
    """

    columns: Integers
    level: Floats
    last: Floats
    before: Floats
    steps: Floats
    sides: Floats
    room: Floats


@compiled
def write_level(
    slot: Any, table: TableArrays, parameters: Floats, task: TaskArrays, total: Floats, again: bool
) -> bool:
    """Evaluate a slot's potential and write its level; return whether all numbers are finite.

    Args:
        slot: Slot of a controller.
        table: Signal table.
        parameters: Parameters of all potentials.
        task: Task coordinates of the slot.
        total: Displacement of the preceding tick, rad, shape (n,).
        again: True if the slot acted in the preceding tick.
    """
    value, feedback, level = table.value, table.records[slot.feedback], task.level
    here = value[feedback.start : feedback.start + feedback.size]
    there = here[:0]
    if slot.reference >= 0:
        reference = table.records[slot.reference]
        there = value[reference.start : reference.start + reference.size]
    own = parameters[slot.parameter : slot.parameter + slot.parameters]
    size, rows = slot.size, feedback.rows
    residual, slope = np.zeros(size), np.zeros((0 if slot.identity else size, rows))
    phi: float = call_at(slot.address, here, there, own, residual, slope)  # type: ignore[call-arg]
    jacobian = table.jacobian[feedback.row : feedback.row + rows]
    fill(task.sides, 0.0)
    whole = slope
    if slot.side != 0.0:
        whole = slope.copy()
        _find_room(slot.side, here, there, residual, slope, task)
    _select(jacobian, slope, slot.identity, task.columns, level)
    step = np.empty(size)
    if slot.rule == _RESIDUAL:
        error, unit, ripple = norm(residual), 1.0, _ripple(residual, level, task.steps)
        if slot.funnel[0] > 0.0:
            residual[2] += _height(here, there, slot.funnel)
        copy(step, residual, 0.5)
    else:
        error, unit = _follow_gradient(slot.rule, residual, level[0])
        ripple = _ripple(np.ones(1), level, task.steps) / unit if unit > 0.0 else 0.0
        slot.stride = _stride(slot.stride, task.last[0], level[0], total) if again else 1.0
        step[0] = slot.stride * residual[0]
    if not (math.isfinite(phi) and _is_finite(level)):
        return False
    if not displace(step, residual, level, unit, slot.bounds, task.before):
        return False
    if slot.mode == TRACK:
        slot.phi, slot.error, slot.ripple = phi, error, ripple
    if slot.side != 0.0:
        _select(jacobian, whole, False, task.columns, level)
    return True


@compiled
def _find_room(
    side: float, here: Floats, there: Floats, residual: Floats, slope: Floats, task: TaskArrays
) -> None:
    """Find the components of a bound that obey it; their slopes become 0."""
    for i in range(len(residual)):
        if residual[i] == 0.0:
            task.sides[i], task.room[i] = side, 0.0
            for row in range(slope.shape[1]):
                task.room[i] += side * slope[i, row] * (there[row] - here[row])
            fill(slope[i], 0.0)


@compiled
def allow(slot: Any, task: TaskArrays, leads: Floats, requested: Floats) -> None:
    """Let levels below move as far as each bound that holds allows in this tick.

    Args:
        slot: Slot of the bound.
        task: Task coordinates of the slot.
        leads: Distances of the joints' references from their positions, rad, shape (n,).
        requested: Displacement that each row requests or allows, shape (k,).
    """
    for i in range(len(requested)):
        side = task.sides[i]
        if side != 0.0:
            ahead = side * dot(task.level[i], leads) if slot.lags else 0.0
            requested[i] = side * brake_before(task.room[i] - ahead, slot.bounds)


@compiled
def _follow_gradient(rule: int, residual: Floats, gradient: Floats) -> tuple[float, float]:
    """Scale a scalar potential's gradient (n,) to a unit vector.

    The motion of the joints is the same. Without scaling, the law would take a short gradient for a
    singularity and damp it. But the unit of a row does not indicate a singularity.

    Returns:
        The potential's error, and the scale of its one coordinate.
    """
    length = norm(gradient)
    if rule == _DESCENT:
        residual[0] = -length * length
    unit = 1.0 / length if length > 0.0 else 0.0
    scale(gradient, unit)
    return abs(residual[0]), unit


@compiled
def _ripple(residual: Floats, level: Floats, steps: Floats) -> float:
    """Return the change of half the squared residual if each joint moves by a step, to first order.

    Args:
        residual: Residual, shape (k,).
        level: Task coordinates per joint, shape (k, n).
        steps: Steps of the joints' encoders, rad or m, shape (n,).
    """
    ripple = 0.0
    for joint in range(len(steps)):
        slope = 0.0
        for i in range(len(residual)):
            slope += residual[i] * level[i, joint]
        ripple += abs(slope) * steps[joint]
    return ripple


@compiled
def _stride(stride: float, last: Floats, gradient: Floats, total: Floats) -> float:
    """Return the share of its step that a scalar potential takes in this tick.

    The slope along the last displacement shows whether it passed the lowest point on its way. By
    the secant, it was too long by the share of the slope that has changed its sign.

    Args:
        stride: Share in the preceding tick.
        last: Gradient there, of unit length, shape (n,).
        gradient: Gradient here, of unit length, shape (n,).
        total: Displacement in between, rad, shape (n,).
    """
    slope, now = dot(last, total), dot(gradient, total)
    if slope < 0.0 < now:
        return stride * max(slope / (slope - now), _SHORTEST)
    return min(_LONGER * stride, 1.0)


@compiled
def _is_finite(rows: Floats) -> bool:
    total = 0.0
    for i in range(rows.shape[0]):
        for column in range(rows.shape[1]):
            total += 0.0 * rows[i, column]
    return total == 0.0


@compiled
def _select(
    jacobian: Floats, slope: Floats, identity: bool, columns: Integers, level: Floats
) -> None:
    """Write slope times the columns of a Jacobian, shape (k, n), 0 for columns of number -1."""
    for i in range(len(level)):
        fill(level[i], 0.0)
        if identity:
            for place in range(len(columns)):
                if columns[place] >= 0:
                    level[i, place] = jacobian[i, columns[place]]
            continue
        for row in range(len(jacobian)):
            weight = slope[i, row]
            if weight != 0.0:
                for place in range(len(columns)):
                    if columns[place] >= 0:
                        level[i, place] += weight * jacobian[row, columns[place]]


@compiled
def _height(here: Floats, there: Floats, funnel: Floats) -> float:
    """Return the height above its reference of an approach, which grows with the lateral error."""
    lateral = math.hypot(there[0] - here[0], there[1] - here[1])
    height: float = min(max(funnel[2] * (lateral - funnel[1]), 0.0), funnel[0])
    return height


@compiled
def fraction_of(slot: Any) -> float:
    """Return the share of the way to its target that a slot requests in a tick."""
    share: float = slot.bounds[0] * slot.bounds[3]
    # A Newton step is half the residual.
    return min(0.5 * share if slot.rule == _RESIDUAL else share, 1.0)
