"""Tick: from the posture to potentials, predicates and references, in one compiled call.

A controller's slot names the rows of its feedback and its reference in the signal table. It also
holds the potential that compares them, and the bounds of its task coordinates' rates. Slots that
act together, highest priority first, write the levels of a stack, which the control law composes.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cbdsl.control.conditions.condition_plan import note_conditions
from cbdsl.control.conditions.predicate import note, require_settled
from cbdsl.control.hessian import has_hessian, write_hessian
from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.level import LevelArrays
from cbdsl.control.plan import PlanArrays
from cbdsl.control.potential import Rule
from cbdsl.control.reference import NEEDS_HESSIANS, NOT_FINITE, move
from cbdsl.control.slot import IDLE, TRACK, error_bound
from cbdsl.control.slot_mode import decide
from cbdsl.control.slot_step import TaskArrays, allow, fraction_of, write_level
from cbdsl.control.stack import TICKS
from cbdsl.kinematics.link_distance import DistanceArrays
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.handle import Handle
from cbdsl.numeric.vector import copy, fill
from cbdsl.sensing.signal_arrays import SignalArrays, TableArrays
from cbdsl.sensing.table.refresh import write_rows

_RESIDUAL = int(Rule.RESIDUAL)

#: Outcomes of a tick in which no slot fails.
MOVED, RESTED, UNSOUND = -1, -2, -3


class ActingArrays(NamedTuple):
    """Controllers that act together, and the joints that they move.

    Attributes:
        needed: Rows of the signal table to be refreshed, shape (r,).
        clock: Stamp of the posture, shape (1,).
        order: Active slots, required ones first, shape (levels, 4). The columns are the slot, the
            slots that it follows and requires, -1 for none that acts with it, and its place in the
            order of priority.
        columns: Joint index of each of the stack's n joints for each level, -1 for a joint that its
            slot does not move, shape (levels, n).
        joints: Joint index of each of the stack's n joints, shape (n,).
        steps: Steps of their encoders, rad or m, shape (n,).
        watched: Numbers of the conditions to evaluate, shape (c,).
    """

    needed: Integers
    clock: Integers
    order: Integers
    columns: Integers
    joints: Integers
    steps: Floats
    watched: Integers


class TickArrays(NamedTuple):
    """Arrays of a tick.

    Attributes:
        signals: Measurements, signal table and joint tree.
        plan: Slots of all controllers.
        acting: Controllers that act.
        levels: Arrays of their stack, whose next tick begins.
        law: Bounds and guards, and the law's result.
        references: References of the actuated joints, rad, shape (all,).
        load_guards: Guards of loads, shape (g,) of ``load_guard.LOAD_GUARD``.
        distances: Pairs of links that keep a distance; ``None`` without a clearance.
    """

    signals: SignalArrays
    plan: PlanArrays
    acting: ActingArrays
    levels: LevelArrays
    law: LawArrays
    references: Floats
    load_guards: Records
    distances: DistanceArrays | None


@compiled_once
def tick(arrays: Handle) -> int:
    """Refresh the rows that a stack needs, let its slots act, and move the references.

    Args:
        arrays: Handle of ``TickArrays``.

    Returns:
        ``MOVED``; ``RESTED`` if no slot acts; ``UNSOUND`` if the law cannot compute with the
        levels; otherwise the place of the slot with invalid numbers.
    """
    held: TickArrays = arrays.held
    signals, plan, acting, levels, law = held.signals, held.plan, held.acting, held.levels, held.law
    write_rows(signals, acting.needed, acting.clock[0])
    if len(acting.watched) > 0:
        note_conditions(acting.watched, plan.conditions, plan.operations, plan.terms, signals.table)
    levels.clock[0] = (levels.clock[0] + 1) % TICKS
    active = False
    for number in range(len(acting.order)):
        if not _write_level(number, held):
            return int(acting.order[number, 3])
        active |= levels.ages[acting.order[number, 3]] > 0
    if not active:
        return RESTED
    references, joints, load_guards = held.references, acting.joints, held.load_guards
    distances = held.distances
    # Levels that needed their Hessians need them again, as a rule: the law then composes once.
    bends = bool(levels.bent[0])
    if bends:
        _bend(acting, levels, plan, signals)
    outcome = move(references, joints, signals, levels, bends, law, load_guards, distances)
    if outcome == NEEDS_HESSIANS:
        _bend(acting, levels, plan, signals)
        outcome = move(references, joints, signals, levels, True, law, load_guards, distances)
    return UNSOUND if outcome == NOT_FINITE else MOVED


@compiled
def _write_level(number: int, held: TickArrays) -> bool:
    """Decide a slot's mode, and write its level if it acts; return whether its numbers are finite.

    Args:
        number: Row of the slot in ``acting.order``.
        held: Arrays of the tick.
    """
    signals, plan, acting, levels, law = held.signals, held.plan, held.acting, held.levels, held.law
    who, columns = acting.order[number], acting.columns
    slot, place = plan.slots[who[0]], who[3]
    newest, ages, end = levels.clock[0], levels.ages, levels.ends[place]
    first = end - slot.size
    displacement = plan.before[slot.start : slot.start + slot.size]
    decide(slot, who[1:3], plan, signals, columns[place])
    if slot.mode == IDLE:
        ages[place] = 0
        if slot.forgotten:
            fill(displacement, 0.0)
        return True
    task = TaskArrays(
        columns[place],
        levels.rows[newest, first:end],
        levels.rows[newest - 1, first:end],
        displacement,
        acting.steps,
        levels.sides[first:end],
        np.empty(slot.size),
    )
    again = ages[place] > 0
    if not write_level(slot, signals.table, plan.parameters, task, law.displacement, again):
        return False
    copy(levels.requested[first:end], displacement, 1.0)
    if slot.side != 0.0:
        leads = np.empty(len(acting.joints))
        for joint in range(len(leads)):
            at = acting.joints[joint]
            leads[joint] = held.references[at] - signals.sensed.positions[at]
        allow(slot, task, leads, levels.requested[first:end])
    levels.fractions[place], levels.errors[place] = fraction_of(slot), slot.error
    levels.curved[place] = slot.rule == _RESIDUAL and has_hessian(slot, signals.table.records)
    ages[place] = min(ages[place] + 1, TICKS)
    if slot.mode == TRACK:
        _note(slot, who[2], plan, signals.table)
    return True


@compiled
def _note(slot: Any, required: int, plan: PlanArrays, table: TableArrays) -> None:
    """Note a slot's potential for its predicate.

    A controller is not at rest while its required controller seeks contact again.
    """
    measured = table.records[slot.feedback].stamp
    if slot.reference >= 0:
        measured = max(measured, table.records[slot.reference].stamp)
    window = plan.windows[slot.window : slot.window + slot.notes[5]]
    note(slot.phi, slot.ripple, measured, slot.settings, window, slot.notes)
    is_held = not slot.requires or plan.slots[required].mode == TRACK
    bound = error_bound(slot, table.records, table.value) if is_held else -math.inf
    require_settled(slot.error, bound, slot.notes)


@compiled
def _bend(
    acting: ActingArrays, levels: LevelArrays, plan: PlanArrays, signals: SignalArrays
) -> None:
    """Write the Hessians of all levels that act and bend."""
    for number in range(len(acting.order)):
        place = acting.order[number, 3]
        if levels.ages[place] > 0 and levels.curved[place]:
            slot, end = plan.slots[acting.order[number, 0]], levels.ends[place]
            hessian = levels.hessians[end - slot.size : end]
            write_hessian(slot, signals, plan.parameters, acting.columns[place], hessian)
