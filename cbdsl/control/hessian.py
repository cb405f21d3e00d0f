"""Hessians of task coordinates; compiled.

Model. The task coordinates of a spring are a slope times the rows of its feedback. Their Hessian is
thus the slope times the derivative of those rows (``sensing.curvature``), made symmetric. In
exponential coordinates of a rotation, half of the derivative of the axes is the second derivative,
which is the same. A tip that may turn about its own axis a couples the turn about a with the turns
across: s . (a x w_j) (a . w_i), for a task coordinate s . w. Assumption: the slope itself counts as
constant. That is exact for springs along some axes or all, and for small angles otherwise.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cbdsl.control.potential import call_at
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import cross, dot
from cbdsl.sensing.signal_arrays import SignalArrays, TableArrays
from cbdsl.sensing.table.curvature import BENDING, bend_carried, bend_row


@compiled
def has_hessian(slot: Any, table: Records) -> bool:
    """Return whether the task coordinates of a slot's spring bend as the joints move."""
    return bool(slot.carried or table[slot.feedback].kind in BENDING)


@compiled_once
def write_hessian(
    slot: Any, signals: SignalArrays, parameters: Floats, columns: Integers, hessian: Floats
) -> None:
    """Write the Hessian of a slot's task coordinates.

    Args:
        slot: Slot of a spring whose feedback ``has_hessian``.
        signals: Arrays of the signals.
        parameters: Parameters of all potentials.
        columns: Joint index of each of the stack's n joints, -1 for a joint that the slot does not
            move, shape (n,).
        hessian: Becomes the second derivatives, shape (k, n, n).
    """
    table, tree = signals.table, signals.tree
    feedback, jacobian = table.records[slot.feedback], table.jacobian
    bends = np.zeros((feedback.rows, jacobian.shape[1], jacobian.shape[1]))
    if slot.carried:
        bend_carried(jacobian[feedback.row : feedback.row + 3], tree, bends)
    else:
        bend_row(feedback, table, tree, bends)
    slope = _slope(slot, feedback, table, parameters)
    _select(bends, slope, columns, hessian)
    if slot.spin >= 0:
        _spin(slot, feedback, table, slope, columns, hessian)


@compiled
def _slope(slot: Any, feedback: Any, table: TableArrays, parameters: Floats) -> Floats:
    """Return a slot's task coordinates per row of its feedback, shape (k, rows)."""
    if slot.identity:
        return np.eye(slot.size)
    value = table.value
    here = value[feedback.start : feedback.start + feedback.size]
    there = here[:0]
    if slot.reference >= 0:
        reference = table.records[slot.reference]
        there = value[reference.start : reference.start + reference.size]
    own = parameters[slot.parameter : slot.parameter + slot.parameters]
    residual, slope = np.zeros(slot.size), np.zeros((slot.size, feedback.rows))
    call_at(slot.address, here, there, own, residual, slope)  # type: ignore[call-arg]
    return slope


@compiled
def _select(bends: Floats, slope: Floats, columns: Integers, hessian: Floats) -> None:
    """Write the symmetric part of slope times the change of the rows, in the stack's joints."""
    joints = len(columns)
    hessian[:] = 0.0
    for i in range(len(hessian)):
        for row in range(len(bends)):
            weight = 0.5 * slope[i, row]
            if weight == 0.0:
                continue
            for j in range(joints):
                one = columns[j]
                if one < 0:
                    continue
                for k in range(j + 1):
                    other = columns[k]
                    if other >= 0:
                        both = bends[row, one, other] + bends[row, other, one]
                        hessian[i, j, k] += weight * both
        for j in range(joints):
            for k in range(j):
                hessian[i, k, j] = hessian[i, j, k]


@compiled
def _spin(
    slot: Any, feedback: Any, table: TableArrays, slope: Floats, columns: Integers, hessian: Floats
) -> None:
    """Add the coupling of a turn about the tip's free axis with turns across it."""
    first = feedback.rows - 3
    turning = table.jacobian[feedback.row + first : feedback.row + feedback.rows]
    start = feedback.start + feedback.size - 9
    axis, side = np.empty(3), np.empty(3)
    for i in range(3):
        axis[i] = table.value[start + 3 * i + slot.spin]
    joints = len(columns)
    along, across = np.zeros(joints), np.zeros(joints)
    for i in range(len(hessian)):
        # s . (a x w) = (s x a) . w
        cross(slope[i, first:].copy(), axis, side)
        for j in range(joints):
            along[j] = across[j] = 0.0
            if columns[j] >= 0:
                turn = turning[:, columns[j]].copy()
                along[j], across[j] = dot(axis, turn), dot(side, turn)
        for j in range(joints):
            for k in range(joints):
                hessian[i, j, k] += 0.5 * (along[j] * across[k] + across[j] * along[k])
