"""Slot: constants and state of one controller in compiled code."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cbdsl.control.conditions.onset import restart_onset
from cbdsl.control.conditions.predicate import reset
from cbdsl.numeric.arrays import Floats, Records
from cbdsl.numeric.compiled import compiled_once
from cbdsl.numeric.vector import fill, norm

#: Modes of a slot in a tick: idle, because a signal that it needs is undefined; tracking, which
#: moves its feedback to the reference; or searching, the same motion while the feedback is not
#: measured, so that it becomes measured.
IDLE, TRACK, SEARCH = range(3)

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
        ("ripple", np.float64),  # change of phi if each joint moves by a step of its encoder
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
        # Bound: 1 for an upper one, -1 for a lower one, 0 for none; and whether its feedback moves
        # with the positions of joints, which lag behind their references.
        ("side", np.float64),
        ("lags", np.bool_),
        # Share of its step that a scalar potential takes, by the overshoot of the last steps.
        ("stride", np.float64),
    ]
)


@compiled_once
def error_bound(slot: Any, table: Records, value: Floats) -> float:
    """Return the largest error with which a slot counts as at rest, in its feedback's unit."""
    bound: float = slot.tolerance
    if slot.reference >= 0 and slot.share < math.inf:
        reference = table[slot.reference]
        there = value[reference.start : reference.start + reference.size]
        bound = min(bound, slot.share * norm(there))
    return bound


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
