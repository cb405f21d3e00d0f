"""Mode of a slot in a tick, by the signals that are defined; compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cbdsl.control.conditions.onset import note_load, restart_onset
from cbdsl.control.conditions.predicate import note_undefined
from cbdsl.control.plan import PlanArrays
from cbdsl.control.slot import IDLE, SEARCH, TRACK
from cbdsl.kinematics.forward import place_point
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled
from cbdsl.sensing.signal_arrays import SignalArrays, TableArrays
from cbdsl.sensing.table.refresh import DEFINED, UNDEFINED, displace_value
from cbdsl.sensing.touch.fingertip import add_contact

# Largest distance of a contact from the seen object, taken for a ball of its apparent size, m.
# Contacts with objects are up to 1.6 cm off; those with the table around a flat one, from 3.3 cm.
_BESIDE = 0.02

# Longest time for which a controller that has lost its contact counts as engaged, s.
_REGRASP = 2.0


@compiled
def decide(
    slot: Any, peers: Integers, plan: PlanArrays, signals: SignalArrays, columns: Integers
) -> None:
    """Set the slot's mode from its rows' state and the state of its peers.

    Args:
        slot: Slot of a controller.
        peers: Slots that it follows and requires, -1 for none that acts with it, shape (2,).
        plan: Slots of all controllers.
        signals: Arrays of the signals.
        columns: Joint index of each of the stack's n joints, -1 for a joint that the slot does not
            move, shape (n,).
    """
    leader, required, table = peers[0], peers[1], signals.table
    given = not slot.requires or bool(required >= 0 and plan.slots[required].engaged)
    if slot.anchor >= 0:
        _anchor(slot, plan.onsets, table, given)
    slot.astray = _is_astray(slot, signals)
    slot.mode = IDLE
    known = slot.reference < 0 or table.records[slot.reference].defined == DEFINED
    if not given or not known or slot.blocked:
        _forget(slot)
        slot.engaged = False
        return
    feedback = table.records[slot.feedback]
    responds = slot.watches or _responds(feedback, table.jacobian, columns)
    if feedback.defined == DEFINED and responds and not slot.astray:
        slot.mode = TRACK
        slot.seeking = slot.exhausted = False
        slot.engaged = True
        slot.forgotten = False
        slot.lost = 0
        return
    _forget(slot)
    if slot.seeks and not slot.seeking and not slot.exhausted:
        slot.seeking = not slot.follows or (leader >= 0 and plan.slots[leader].error < slot.within)
    if slot.seeking and slot.joints > 0 and _beyond(slot, signals.sensed.positions, plan.listed):
        slot.seeking, slot.exhausted = False, True
    if slot.seeking and feedback.defined != UNDEFINED:
        slot.mode = SEARCH
        slot.forgotten = False
        slot.lost += 1
        slot.engaged = slot.engaged and slot.lost * slot.settings[2] <= _REGRASP
    else:
        slot.engaged = False


@compiled
def _is_astray(slot: Any, signals: SignalArrays) -> bool:
    """Return whether the fingertips are in contact, and not all of them at the sought object.

    The object is taken for a ball of its apparent size around its remembered position. Force and
    torque of a load cell determine the place of the contact on the fingertip.
    """
    records, value = signals.table.records, signals.table.value
    feedback, there = records[slot.feedback], records[slot.object]
    if slot.object < 0 or feedback.defined != DEFINED:
        return False
    if there.defined != DEFINED:
        return True
    place = np.empty(3)
    for number in range(feedback.part, feedback.part + feedback.parts):
        part, distance = signals.table.parts[number], 0.0
        place_point(signals.tree.frames[part.frame], part.origin, place)
        add_contact(signals.sensed.loads[part.cell], part.radius, place)
        for i in range(3):
            distance += (place[i] - value[there.start + i]) ** 2
        if distance > (there.radius + _BESIDE) ** 2:
            return True
    return False


@compiled
def _anchor(slot: Any, onsets: Records, table: TableArrays, given: bool) -> None:
    """Store the displaced feedback at activation as the reference.

    A load is stored after its change, by its earlier mean, and forgotten when it is gone.
    """
    records, value = table.records, table.value
    feedback, row = records[slot.feedback], records[slot.anchor]
    here = value[feedback.start : feedback.start + feedback.size]
    present = given and feedback.defined == DEFINED
    if slot.onset >= 0 and not present:
        restart_onset(onsets[slot.onset])
        slot.anchored = False
        row.defined = UNDEFINED
    if slot.anchored or not present:
        return
    offset = records[slot.offset]
    change = value[offset.start : offset.start + offset.size]
    kept = value[row.start : row.start + row.size]
    if slot.onset >= 0:
        onset = onsets[slot.onset]
        tip = here[:0]
        if onset.tip >= 0:
            carrier = records[onset.tip]
            tip = value[carrier.start : carrier.start + carrier.size]
        if not note_load(onset, here, tip):
            return
        displace_value(onset.mean, change, False, kept)
    else:
        displace_value(here, change, slot.turned, kept)
    slot.anchored = True
    row.defined, row.stamp = DEFINED, feedback.stamp


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
