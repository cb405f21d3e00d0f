"""One tick: from the posture to potentials, predicates and references, in one compiled call.

A controller's slot says which row of the signal table is its feedback and which its reference, by
which potential they are compared, and how fast its task coordinates may move. Slots that act
together, highest priority first, write the levels of a stack, which the control law composes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.potential import Rule, call_at
from cbdsl.control.predicate import note, note_undefined, reset
from cbdsl.control.rate import displace
from cbdsl.control.reference import move
from cbdsl.control.signal import Floats
from cbdsl.control.stack import TICKS
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import copy, fill, norm, scale
from cbdsl.sensing.refresh import DEFINED, UNDEFINED, refresh

Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]
Records = NDArray[Any]

_DESCENT, _RESIDUAL = int(Rule.DESCENT), int(Rule.RESIDUAL)

#: What a slot does in a tick: nothing, since something that it needs is undefined; move its
#: feedback to the reference; the same while the feedback is no measurement, so that it becomes one.
IDLE, TRACK, SEARCH = range(3)

#: What comes of a tick where no slot fails.
MOVED, RESTED, UNSOUND = -1, -2, -3

#: A controller's slot.
SLOT = np.dtype(
    [
        ("mode", np.int64),
        ("address", np.int64),  # of the potential
        ("rule", np.int64),
        ("identity", np.bool_),
        ("feedback", np.int64),  # rows of the signal table
        ("reference", np.int64),
        ("parameter", np.int64),  # the potential's, and how many
        ("parameters", np.int64),
        ("start", np.int64),  # task coordinates, and how many
        ("size", np.int64),
        ("phi", np.float64),
        ("error", np.float64),  # norm of the residual
        ("bounds", np.float64, 6),  # of ``rate.displace``
        # The predicate, as ``predicate.note`` keeps it.
        ("window", np.int64),
        ("settings", np.float64, 3),
        ("notes", np.int64, 6),
        # An approach from above: its height, the lateral error within which it ends, and its slope.
        ("funnel", np.float64, 3),
        # Acting while the feedback is undefined: whether, whether once a leader is near, how near,
        # until which joints are beyond which angle.
        ("seeks", np.bool_),
        ("follows", np.bool_),
        ("within", np.float64),
        ("until", np.float64),
        ("joint", np.int64),
        ("joints", np.int64),
        ("requires", np.bool_),
        ("seeking", np.bool_),
        ("exhausted", np.bool_),
        # Whether it is defined, or was and seeks to be again; whether it has been undefined before;
        # whether what it needs could not be prepared.
        ("engaged", np.bool_),
        ("forgotten", np.bool_),
        ("blocked", np.bool_),
    ]
)


@compiled_once
def tick(
    needed: Integers,
    clock: Integers,
    positions: Floats,
    loads: Floats,
    feeling: Booleans,
    table: Records,
    parts: Records,
    support: Integers,
    value: Floats,
    jacobian: Floats,
    tree: Records,
    frames: Floats,
    axes: Floats,
    slots: Records,
    parameters: Floats,
    before: Floats,
    windows: Floats,
    listed: Integers,
    acting: Integers,
    columns: Integers,
    turn: Integers,
    rows: Floats,
    ages: Integers,
    wanted: Floats,
    ends: Integers,
    references: Floats,
    joints: Integers,
    limits: Floats,
    guards: Floats,
    total: Floats,
    locked: Booleans,
    singular: Floats,
) -> int:
    """Refresh the rows that a stack needs, let its slots act, and move the references.

    Args:
        needed: rows to be refreshed, shape (r,).
        clock: stamp of the posture, shape (1,).
        positions: of the actuated joints, rad, shape (all,).
        loads, feeling, table, parts, support, value, jacobian, tree, frames, axes: as of
            ``refresh``.
        slots: all controllers', shape (s,) of ``SLOT``.
        parameters: of their potentials.
        before: displacements of their task coordinates in the tick before.
        windows: of their potentials.
        listed: joints that searches look at.
        acting: which slots act, highest priority first, shape (levels, 3), with the slots that they
            follow and require, -1 for none that acts with them.
        columns: which joint each of the stack's n is for a slot, -1 for one that it does not move,
            shape (levels, n).
        turn, rows, ages, wanted, ends: of the stack, whose next tick begins.
        references: of the actuated joints, rad, shape (all,).
        joints: which joint each of the stack's n is, shape (n,).
        limits, guards, total, locked, singular: as of ``move``.

    Returns:
        ``MOVED``; ``RESTED`` where no slot acts; ``UNSOUND`` where the law cannot compute with the
        levels; otherwise the place of the slot whose numbers cannot be computed with.
    """
    refresh(
        needed, clock[0], positions, loads, feeling, table, parts, support, value, jacobian,
        tree, frames, axes,
    )  # fmt: skip
    turn[0] = (turn[0] + 1) % TICKS
    newest, anything, start = turn[0], False, 0
    for place in range(len(acting)):
        slot = slots[acting[place, 0]]
        level = rows[newest, start : ends[place]]
        own = columns[place]
        start = ends[place]
        displacement = before[slot.start : slot.start + slot.size]
        _decide(slot, slots, acting[place], positions, listed, table, jacobian, own)
        if slot.mode == IDLE:
            ages[place] = 0
            if slot.forgotten:
                fill(displacement, 0.0)
            continue
        if not _act(slot, table, value, jacobian, parameters, own, level, displacement):
            return place
        copy(wanted[start - slot.size : start], displacement, 1.0)
        ages[place] = min(ages[place] + 1, TICKS)
        anything = True
        if slot.mode == TRACK:
            measured = table[slot.feedback].stamp
            if slot.reference >= 0:
                measured = max(measured, table[slot.reference].stamp)
            window = windows[slot.window : slot.window + slot.notes[5]]
            note(slot.phi, measured, slot.settings, window, slot.notes)
    if not anything:
        return RESTED
    if not move(
        references, positions, joints, newest, rows, ages, wanted, ends, limits, guards,
        total, locked, singular,
    ):  # fmt: skip
        return UNSOUND
    return MOVED


@compiled
def _decide(
    slot: Any,
    slots: Records,
    acting: Integers,
    positions: Floats,
    listed: Integers,
    table: Records,
    jacobian: Floats,
    columns: Integers,
) -> None:
    """Set a slot's mode, by what is defined and what those that act with it have come to."""
    leader, condition = acting[1], acting[2]
    given = not slot.requires or (condition >= 0 and slots[condition].engaged)
    known = slot.reference < 0 or table[slot.reference].defined == DEFINED
    slot.mode = IDLE
    if not given or not known or slot.blocked:
        _forget(slot)
        slot.engaged = False
        return
    feedback = table[slot.feedback]
    if feedback.defined == DEFINED and _responds(feedback, jacobian, columns):
        slot.mode = TRACK
        slot.seeking = slot.exhausted = False
        slot.engaged = True
        slot.forgotten = False
        return
    _forget(slot)
    if slot.seeks and not slot.seeking and not slot.exhausted:
        slot.seeking = not slot.follows or (leader >= 0 and slots[leader].error < slot.within)
    if slot.seeking and slot.joints > 0 and _beyond(slot, positions, listed):
        slot.seeking, slot.exhausted = False, True
    if slot.seeking and feedback.defined != UNDEFINED:
        slot.mode = SEARCH
        slot.forgotten = False
    else:
        slot.engaged = False


@compiled
def _forget(slot: Any) -> None:
    """Have no potential, and start from rest once there is one again, unless it is sought."""
    if slot.forgotten:
        return
    note_undefined(slot.notes)
    slot.phi = slot.error = math.nan
    # The robot may be doing something else by the time the signal is back.
    if not slot.seeking:
        slot.forgotten = True


@compiled
def _responds(feedback: Any, jacobian: Floats, columns: Integers) -> bool:
    """Whether a joint that the slot moves changes its feedback."""
    for row in range(feedback.row, feedback.row + feedback.rows):
        for place in range(len(columns)):
            if columns[place] >= 0 and jacobian[row, columns[place]] != 0.0:
                return True
    return False


@compiled
def _beyond(slot: Any, positions: Floats, listed: Integers) -> bool:
    """Whether all joints that a search looks at are beyond its end."""
    for place in range(slot.joint, slot.joint + slot.joints):
        if not positions[listed[place]] > slot.until:
            return False
    return True


@compiled
def _act(
    slot: Any,
    table: Records,
    value: Floats,
    jacobian: Floats,
    parameters: Floats,
    columns: Integers,
    level: Floats,
    before: Floats,
) -> bool:
    """Evaluate a slot's potential and write its level; returns whether all numbers were finite.

    Args:
        columns: which joint each of the stack's n is, -1 for those that count as still.
        level: becomes task coordinates per joint, shape (k, n).
        before: displacement of the task coordinates in the tick before, shape (k,); becomes this
            tick's.
    """
    feedback = table[slot.feedback]
    here = value[feedback.start : feedback.start + feedback.size]
    there = here[:0]
    if slot.reference >= 0:
        reference = table[slot.reference]
        there = value[reference.start : reference.start + reference.size]
    own = parameters[slot.parameter : slot.parameter + slot.parameters]
    size, rows = slot.size, feedback.rows
    residual, slope = np.zeros(size), np.zeros((0 if slot.identity else size, rows))
    phi: float = call_at(slot.address, here, there, own, residual, slope)  # type: ignore[call-arg]
    _select(jacobian[feedback.row : feedback.row + rows], slope, slot.identity, columns, level)
    step = np.empty(size)
    if slot.rule == _RESIDUAL:
        error, unit = norm(residual), 1.0
        if slot.funnel[0] > 0.0:
            residual[2] += _height(here, there, slot.funnel)
        copy(step, residual, 0.5)
    else:
        error, unit = _follow_gradient(slot.rule, residual, level[0])
        step[0] = residual[0]
    if not (math.isfinite(phi) and _is_finite(level)):
        return False
    if not displace(step, residual, level, unit, slot.bounds, before):
        return False
    if slot.mode == TRACK:
        slot.phi, slot.error = phi, error
    return True


@compiled
def _follow_gradient(rule: int, residual: Floats, gradient: Floats) -> tuple[float, float]:
    """Make a scalar potential's gradient (n,) a unit vector.

    The joints do the same. But the unit of a row says nothing about how near it is to losing its
    influence, and the law would take a short gradient for a singularity and damp it.

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
    """Task coordinates per joint: slope times the columns of a Jacobian; 0 for one numbered -1."""
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
    """How far above its reference an approach begins: the farther, the larger the lateral error."""
    lateral = math.hypot(there[0] - here[0], there[1] - here[1])
    height: float = min(max(funnel[2] * (lateral - funnel[1]), 0.0), funnel[0])
    return height


@compiled_once
def reset_slot(slots: Records, number: int, before: Floats) -> None:
    """Forget a slot's activation: its controller is idle."""
    slot = slots[number]
    slot.phi = slot.error = math.nan
    slot.seeking = slot.exhausted = slot.engaged = slot.forgotten = slot.blocked = False
    reset(slot.notes)
    fill(before[slot.start : slot.start + slot.size], 0.0)
