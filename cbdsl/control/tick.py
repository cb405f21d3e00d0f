"""Tick: from the posture to potentials, predicates and references, in one compiled call.

A controller's slot names the rows of its feedback and its reference in the signal table. It also
holds the potential that compares them, and the bounds of its task coordinates' rates. Slots that
act together, highest priority first, write the levels of a stack, which the control law composes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cbdsl.control.hessian import has_hessian, write_hessian
from cbdsl.control.level import LevelArrays
from cbdsl.control.onset import note_load, restart_onset
from cbdsl.control.potential import Rule, call_at
from cbdsl.control.predicate import note, note_undefined, require_settled, reset
from cbdsl.control.rate import displace
from cbdsl.control.reference import NEEDS_HESSIANS, NOT_FINITE, move
from cbdsl.control.stack import TICKS
from cbdsl.kinematics.forward import place_point
from cbdsl.numeric.arrays import Booleans, Floats, Integers, Records
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import copy, dot, fill, norm, scale
from cbdsl.sensing.fingertip import add_contact
from cbdsl.sensing.refresh import DEFINED, UNDEFINED, displace_value, refresh

# Largest growth of a stride in a tick, and its smallest factor.
_LONGER, _SHORTEST = 1.05, 0.2

# Largest distance of a contact from the seen object, taken for a ball of its apparent size, m.
# Contacts with objects are up to 1.6 cm off; those with the table around a flat one, from 3.3 cm.
_BESIDE = 0.02

# Longest time for which a controller that has lost its contact counts as engaged, s.
_REGRASP = 2.0

_DESCENT, _RESIDUAL = int(Rule.DESCENT), int(Rule.RESIDUAL)

#: Modes of a slot in a tick: idle, because a signal that it needs is undefined; tracking, which
#: moves its feedback to the reference; or searching, the same motion while the feedback is not
#: measured, so that it becomes measured.
IDLE, TRACK, SEARCH = range(3)

#: Outcomes of a tick in which no slot fails.
MOVED, RESTED, UNSOUND = -1, -2, -3

#: Slot of a controller.
SLOT = np.dtype(
    [
        ("mode", np.int64),
        ("address", np.int64),  # of the potential
        ("rule", np.int64),
        ("identity", np.bool_),
        ("feedback", np.int64),  # rows of the signal table
        ("reference", np.int64),
        ("parameter", np.int64),  # potential's parameters, and their number
        ("parameters", np.int64),
        ("start", np.int64),  # task coordinates, and their number
        ("size", np.int64),
        ("phi", np.float64),
        ("error", np.float64),  # norm of the residual
        ("bounds", np.float64, 6),  # of ``rate.displace``
        # Predicate in the form of ``predicate.note``.
        ("window", np.int64),
        ("settings", np.float64, 3),
        ("notes", np.int64, 6),
        # The largest error at rest, and the same as a share of the reference's norm; infinite
        # without a bound.
        ("tolerance", np.float64),
        ("share", np.float64),
        # Approach from above: its height, the lateral error within which it ends, and its slope.
        ("funnel", np.float64, 3),
        # Search while the feedback is undefined: whether, whether it starts once a leader is near,
        # how near, the final position of the joints, the side of it, and the joints.
        ("seeks", np.bool_),
        ("follows", np.bool_),
        ("within", np.float64),
        ("until", np.float64),
        ("closing", np.float64),
        ("joint", np.int64),
        ("joints", np.int64),
        # Row of the seen object that it seeks contact with, -1 for none, and whether a fingertip
        # touches something else.
        ("object", np.int64),
        ("astray", np.bool_),
        ("requires", np.bool_),
        ("seeking", np.bool_),
        ("exhausted", np.bool_),
        # Whether it is defined, or was and seeks to be again; whether it was undefined; whether its
        # preparation failed.
        ("engaged", np.bool_),
        ("lost", np.int64),  # ticks since it was defined
        ("forgotten", np.bool_),
        ("blocked", np.bool_),
        # Reference relative to the feedback at activation: the row that stores it, the row of its
        # displacement, whether that is a rotation, the load change that has to precede it, and
        # whether it is stored now. -1 for none.
        ("anchor", np.int64),
        ("offset", np.int64),
        ("turned", np.bool_),
        ("onset", np.int64),
        ("anchored", np.bool_),
        # Whether it observes a feedback that no joint displaces.
        ("watches", np.bool_),
        # Second order: whether the feedback is the position of a held object, and the axis of the
        # tip about which the task lets it turn, -1 for none.
        ("carried", np.bool_),
        ("spin", np.int64),
        # Share of its step that a scalar potential takes, by the overshoot of the last steps.
        ("stride", np.float64),
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
    onsets: Records,
    acting: Integers,
    columns: Integers,
    turn: Integers,
    levels: LevelArrays,
    references: Floats,
    joints: Integers,
    limits: Floats,
    steps: Floats,
    guards: Floats,
    total: Floats,
    locked: Booleans,
    singular: Floats,
    load_guards: Records,
) -> int:
    """Refresh the rows that a stack needs, let its slots act, and move the references.

    Args:
        needed: Rows to be refreshed, shape (r,).
        clock: Stamp of the posture, shape (1,).
        positions: Positions of the actuated joints, rad, shape (all,).
        loads, feeling, table, parts, support, value, jacobian, tree, frames, axes: Arguments of
            ``refresh``.
        slots: Slots of all controllers, shape (s,) of ``SLOT``.
        parameters: Parameters of their potentials.
        before: Displacements of their task coordinates in the preceding tick.
        windows: Windows of their predicates.
        listed: Joints that searches observe.
        onsets: Load changes that slots wait for, shape (o,) of ``onset.ONSET``.
        acting: Active slots, required ones first, shape (levels, 4). The columns are the slot, the
            slots that it follows and requires, -1 for none that acts with it, and its place in the
            order of priority.
        columns: Joint index of each of the stack's n joints for a slot, -1 for a joint that it does
            not move, shape (levels, n).
        turn, levels: Clock and arrays of the stack, whose next tick begins.
        references: References of the actuated joints, rad, shape (all,).
        joints: Joint index of each of the stack's n joints, shape (n,).
        limits, steps, guards, total, locked, singular, load_guards: Arguments of ``move``.

    Returns:
        ``MOVED``; ``RESTED`` if no slot acts; ``UNSOUND`` if the law cannot compute with the
        levels; otherwise the place of the slot with invalid numbers.
    """
    refresh(
        needed, clock[0], positions, loads, feeling, table, parts, support, value, jacobian,
        tree, frames, axes,
    )  # fmt: skip
    turn[0] = (turn[0] + 1) % TICKS
    newest, anything = turn[0], False
    rows, ages, wanted, ends = levels.rows, levels.ages, levels.requested, levels.ends
    for number in range(len(acting)):
        place = int(acting[number, 3])
        slot = slots[acting[number, 0]]
        level = rows[newest, ends[place] - slot.size : ends[place]]
        own = columns[place]
        displacement = before[slot.start : slot.start + slot.size]
        given = not slot.requires or _is_given(slots, acting[number, 2])
        if slot.anchor >= 0:
            _anchor(slot, onsets, table, value, given)
        slot.astray = _is_astray(slot, table, parts, loads, value, frames)
        _decide(slot, slots, acting[number, 1], given, positions, listed, table, jacobian, own)
        if slot.mode == IDLE:
            ages[place] = 0
            if slot.forgotten:
                fill(displacement, 0.0)
            continue
        last = rows[newest - 1, ends[place] - slot.size : ends[place]]
        if not _act(
            slot, table, value, jacobian, parameters, own, level, displacement, last,
            total, ages[place] > 0,
        ):  # fmt: skip
            return place
        copy(wanted[ends[place] - slot.size : ends[place]], displacement, 1.0)
        levels.fractions[place] = _fraction(slot)
        levels.curved[place] = slot.rule == _RESIDUAL and has_hessian(slot, table)
        ages[place] = min(ages[place] + 1, TICKS)
        anything = True
        if slot.mode == TRACK:
            _note(slot, slots, acting[number, 2], windows, table, value)
    if not anything:
        return RESTED
    outcome = move(
        references, positions, joints, newest, levels, False, limits, steps, guards,
        total, locked, singular, load_guards, loads, table, jacobian,
    )  # fmt: skip
    if outcome == NEEDS_HESSIANS:
        _bend(
            acting, columns, levels, slots, table, parts, support, value, jacobian, tree,
            frames, axes, parameters,
        )  # fmt: skip
        outcome = move(
            references, positions, joints, newest, levels, True, limits, steps, guards,
            total, locked, singular, load_guards, loads, table, jacobian,
        )  # fmt: skip
    return UNSOUND if outcome == NOT_FINITE else MOVED


@compiled
def _note(
    slot: Any, slots: Records, required: int, windows: Floats, table: Records, value: Floats
) -> None:
    """Note a slot's potential for its predicate.

    A controller is not at rest while its required controller seeks contact again.
    """
    measured = table[slot.feedback].stamp
    if slot.reference >= 0:
        measured = max(measured, table[slot.reference].stamp)
    window = windows[slot.window : slot.window + slot.notes[5]]
    note(slot.phi, measured, slot.settings, window, slot.notes)
    is_held = not slot.requires or slots[required].mode == TRACK
    bound = error_bound(slot, table, value) if is_held else -math.inf
    require_settled(slot.error, bound, slot.notes)


@compiled
def _fraction(slot: Any) -> float:
    """Return the share of the way to its target that a slot requests in a tick."""
    share: float = slot.bounds[0] * slot.bounds[3]
    # A Newton step is half the residual.
    return min(0.5 * share if slot.rule == _RESIDUAL else share, 1.0)


@compiled
def _bend(
    acting: Integers,
    columns: Integers,
    levels: LevelArrays,
    slots: Records,
    table: Records,
    parts: Records,
    support: Integers,
    value: Floats,
    jacobian: Floats,
    tree: Records,
    frames: Floats,
    axes: Floats,
    parameters: Floats,
) -> None:
    """Write the Hessians of all levels that act and bend."""
    for number in range(len(acting)):
        place = acting[number, 3]
        if levels.ages[place] > 0 and levels.curved[place]:
            slot = slots[acting[number, 0]]
            end = levels.ends[place]
            write_hessian(
                slot, table, parts, support, value, jacobian, tree, frames, axes, parameters,
                columns[place], levels.hessians[end - slot.size : end],
            )  # fmt: skip


@compiled_once
def error_bound(slot: Any, table: Records, value: Floats) -> float:
    """Return the largest error with which a slot counts as at rest, in its feedback's unit."""
    bound: float = slot.tolerance
    if slot.reference >= 0 and slot.share < math.inf:
        reference = table[slot.reference]
        there = value[reference.start : reference.start + reference.size]
        bound = min(bound, slot.share * norm(there))
    return bound


@compiled
def _is_given(slots: Records, required: int) -> bool:
    """Return whether the required slot acts and is engaged; -1 for none."""
    return bool(required >= 0 and slots[required].engaged)


@compiled
def _is_astray(
    slot: Any, table: Records, parts: Records, loads: Floats, value: Floats, frames: Floats
) -> bool:
    """Return whether the fingertips are in contact, and not all of them at the sought object.

    The object is taken for a ball of its apparent size around its remembered position. Force and
    torque of a load cell determine the place of the contact on the fingertip.
    """
    feedback, there = table[slot.feedback], table[slot.object]
    if slot.object < 0 or feedback.defined != DEFINED:
        return False
    if there.defined != DEFINED:
        return True
    place = np.empty(3)
    for number in range(feedback.part, feedback.part + feedback.parts):
        part, distance = parts[number], 0.0
        place_point(frames[part.frame], part.origin, place)
        add_contact(loads[part.cell], part.radius, place)
        for i in range(3):
            distance += (place[i] - value[there.start + i]) ** 2
        if distance > (there.radius + _BESIDE) ** 2:
            return True
    return False


@compiled
def _anchor(slot: Any, onsets: Records, table: Records, value: Floats, given: bool) -> None:
    """Store the displaced feedback at activation as the reference.

    A load is stored after its change, by its earlier mean, and forgotten when it is gone.
    """
    feedback, row = table[slot.feedback], table[slot.anchor]
    here = value[feedback.start : feedback.start + feedback.size]
    present = given and feedback.defined == DEFINED
    if slot.onset >= 0 and not present:
        restart_onset(onsets[slot.onset])
        slot.anchored = False
        row.defined = UNDEFINED
    if slot.anchored or not present:
        return
    offset = table[slot.offset]
    change = value[offset.start : offset.start + offset.size]
    kept = value[row.start : row.start + row.size]
    if slot.onset >= 0:
        onset = onsets[slot.onset]
        tip = here[:0]
        if onset.tip >= 0:
            carrier = table[onset.tip]
            tip = value[carrier.start : carrier.start + carrier.size]
        if not note_load(onset, here, tip):
            return
        displace_value(onset.mean, change, False, kept)
    else:
        displace_value(here, change, slot.turned, kept)
    slot.anchored = True
    row.defined, row.stamp = DEFINED, feedback.stamp


@compiled
def _decide(
    slot: Any,
    slots: Records,
    leader: int,
    given: bool,
    positions: Floats,
    listed: Integers,
    table: Records,
    jacobian: Floats,
    columns: Integers,
) -> None:
    """Set the slot's mode from its rows' state and the state of its leading slot."""
    known = slot.reference < 0 or table[slot.reference].defined == DEFINED
    slot.mode = IDLE
    if not given or not known or slot.blocked:
        _forget(slot)
        slot.engaged = False
        return
    feedback = table[slot.feedback]
    responds = slot.watches or _responds(feedback, jacobian, columns)
    if feedback.defined == DEFINED and responds and not slot.astray:
        slot.mode = TRACK
        slot.seeking = slot.exhausted = False
        slot.engaged = True
        slot.forgotten = False
        slot.lost = 0
        return
    _forget(slot)
    if slot.seeks and not slot.seeking and not slot.exhausted:
        slot.seeking = not slot.follows or (leader >= 0 and slots[leader].error < slot.within)
    if slot.seeking and slot.joints > 0 and _beyond(slot, positions, listed):
        slot.seeking, slot.exhausted = False, True
    if slot.seeking and feedback.defined != UNDEFINED:
        slot.mode = SEARCH
        slot.forgotten = False
        slot.lost += 1
        slot.engaged = slot.engaged and slot.lost * slot.settings[2] <= _REGRASP
    else:
        slot.engaged = False


@compiled
def _forget(slot: Any) -> None:
    """Clear the potential, and restart from rest when it is defined again, unless it is sought."""
    if slot.forgotten:
        return
    note_undefined(slot.notes)
    slot.phi = slot.error = math.nan
    # The robot may move otherwise before the signal is back.
    if not slot.seeking:
        slot.forgotten = True


@compiled
def _responds(feedback: Any, jacobian: Floats, columns: Integers) -> bool:
    """Return whether a joint that the slot moves changes its feedback."""
    for row in range(feedback.row, feedback.row + feedback.rows):
        for place in range(len(columns)):
            if columns[place] >= 0 and jacobian[row, columns[place]] != 0.0:
                return True
    return False


@compiled
def _beyond(slot: Any, positions: Floats, listed: Integers) -> bool:
    """Return whether all joints that a search observes are beyond its end."""
    for place in range(slot.joint, slot.joint + slot.joints):
        if not slot.closing * positions[listed[place]] > slot.closing * slot.until:
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
    last: Floats,
    total: Floats,
    again: bool,
) -> bool:
    """Evaluate a slot's potential and write its level; return whether all numbers are finite.

    Args:
        columns: Joint index of each of the stack's n joints, -1 for joints that count as still.
        level: Becomes the task coordinates per joint, shape (k, n).
        before: Displacement of the task coordinates in the preceding tick, shape (k,); becomes this
            tick's.
        last: Level of the preceding tick, shape (k, n).
        total: Displacement of the preceding tick, rad, shape (n,).
        again: True if the slot acted in the preceding tick.
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
        slot.stride = _stride(slot.stride, last[0], level[0], total) if again else 1.0
        step[0] = slot.stride * residual[0]
    if not (math.isfinite(phi) and _is_finite(level)):
        return False
    if not displace(step, residual, level, unit, slot.bounds, before):
        return False
    if slot.mode == TRACK:
        slot.phi, slot.error = phi, error
    return True


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


@compiled_once
def reset_slot(slots: Records, number: int, before: Floats, onsets: Records) -> None:
    """Reset a slot when its controller becomes idle."""
    slot = slots[number]
    slot.phi = slot.error = math.nan
    slot.seeking = slot.exhausted = slot.engaged = slot.forgotten = slot.blocked = False
    slot.anchored = slot.astray = False
    if slot.onset >= 0:
        restart_onset(onsets[slot.onset])
    reset(slot.notes)
    fill(before[slot.start : slot.start + slot.size], 0.0)
