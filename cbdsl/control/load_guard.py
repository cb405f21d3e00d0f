"""Guards of loads: bounds on the force of a finger or hand to which motion yields; compiled.

The law composes a tick's displacement as if there were no bound. It may press on the touched object
further than a guard allows. Then the admissible part of the tips' motion becomes the level of
highest priority. The law then composes again, so that the remaining motion respects the priorities.
Towards the bound, a hand approaches ever more slowly. Beyond it, the hand backs off, and references
that press from afar return to their joints.

A contact anywhere on an arm is measured by its joints: the torques of their drives in excess of the
links' weight. There is then no tip and no place of contact; the motion of the joints yields along
the torques.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.level import LevelArrays
from cbdsl.control.levels_above import compose_below
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import add, copy, dot, fill, norm, scale
from cbdsl.sensing.signal_arrays import SignalArrays

#: Speed of a hand that approaches without contact, and that backs off from twice the bound.
PACE = 0.04  # m/s
#: The same speed for joints that detect a contact somewhere on their arm.
JOINT_PACE = 0.1  # rad/s
#: Largest number of joints of a guarded arm.
MOST_JOINTS = 32

# Share of a pressing lead that is left after a tick beyond the bound.
_KEPT = 0.8
# Share of the bound below which a guard does nothing.
_NEAR = 0.5

#: Guard of load cells or joints. ``first`` and ``last`` are the first load cell and the one after
#: the last, whose forces add up. ``row`` has the Jacobian of their place. The other fields are the
#: bound, N; the pace, m per tick; the force in this tick, N; and whether the motion yielded. For a
#: guard of joints, ``joints`` is their number, otherwise 0, and ``torques`` are their torques in
#: this tick, N m. The row is then of their positions, and units are N m and rad.
LOAD_GUARD = np.dtype(
    [
        ("first", np.int64),
        ("last", np.int64),
        ("row", np.int64),
        ("bound", np.float64),
        ("pace", np.float64),
        ("force", np.float64),
        ("held", np.bool_),
        ("joints", np.int64),
        ("torques", np.float64, MOST_JOINTS),
    ]
)


@compiled
def give_way(
    load_guards: Records,
    signals: SignalArrays,
    references: Floats,
    here: Floats,
    columns: Integers,
    levels: LevelArrays,
    law: LawArrays,
) -> tuple[Floats, Floats, Integers]:
    """Compose a displacement again that respects the violated guards.

    Args:
        load_guards: Guards, shape (g,) of ``LOAD_GUARD``; the field ``held`` is updated.
        signals: Arrays of the signals.
        references: References of all joints, rad, shape (all,); leads of pressing joints shrink
            beyond a bound.
        here: Measured positions of the levels' joints, rad, shape (n,).
        columns: Joint index of each of the levels' n joints, shape (n,).
        levels: Levels, highest priority first.
        law: Bounds and guards, and the displacement; becomes the yielding displacement.

    Returns:
        Rows, requested displacements and ends of the guards' levels, as in ``compose_below``.
    """
    table, total = signals.table, law.displacement
    joints, held, last, room = len(columns), 0, 0, 0
    for number in range(len(load_guards)):
        room += max(load_guards[number].joints, 3)
    tips, ways = np.zeros((room, joints)), np.zeros(room)
    normals, allowed = np.zeros((len(load_guards), joints)), np.zeros(len(load_guards))
    for number in range(len(load_guards)):
        guard = load_guards[number]
        row, size = table.records[guard.row].row, guard.joints if guard.joints > 0 else 3
        tip, way, force = tips[last : last + size], ways[last : last + size], np.empty(size)
        _add_up(guard, signals.sensed.loads, force)
        _place(table.jacobian[row : row + size], columns, total, tip, way)
        share, pressing = guard.force / guard.bound, dot(force, way)
        most = guard.pace * min(max(1.0 - share, -1.0), 1.0)
        guard.held = share > _NEAR and pressing > most
        if not guard.held:
            continue
        # Across the force the tip moves as requested; otherwise it would slide aside.
        add(way, force, most - pressing)
        normal, allowed[held] = normals[held], most
        for k in range(size):
            add(normal, tip[k], force[k])
        held, last = held + 1, last + size
        if share > 1.0:
            _relieve(references, here, columns, normal)
    rows, wanted = np.zeros((held + last, joints)), np.empty(held + last)
    for k in range(held):
        copy(rows[k], normals[k], 1.0)
        wanted[k] = allowed[k]
    for k in range(last):
        copy(rows[held + k], tips[k], 1.0)
        wanted[held + k] = ways[k]
    ends = np.array((held, held + last)) if held > 0 else np.zeros(0, np.int64)
    if held > 0:
        compose_below(rows, wanted, ends, here, levels, law)
    return rows, wanted, ends


@compiled
def _add_up(guard: Any, loads: Floats, force: Floats) -> None:
    """Compute a guard's force; ``force`` becomes its direction, shape (k,), or 0 without force."""
    fill(force, 0.0)
    for joint in range(guard.joints):
        force[joint] = guard.torques[joint]
    for cell in range(guard.first, guard.last):
        add(force, loads[cell, :3], 1.0)
    guard.force = norm(force)
    if guard.force > 0.0:
        scale(force, 1.0 / guard.force)


@compiled
def _place(jacobian: Floats, columns: Integers, total: Floats, tip: Floats, way: Floats) -> None:
    """Compute a tip's motion per joint, shape (k, n), and by a displacement, m, shape (k,)."""
    for k in range(len(tip)):
        for place in range(len(columns)):
            tip[k, place] = jacobian[k, columns[place]]
        way[k] = dot(tip[k], total)


@compiled
def _relieve(reference: Floats, here: Floats, columns: Integers, normal: Floats) -> None:
    """Reduce the leads of references along a force if they press."""
    lead, square = 0.0, dot(normal, normal)
    for place in range(len(columns)):
        lead += normal[place] * (reference[columns[place]] - here[place])
    if lead > 0.0 and square > 0.0:
        for place in range(len(columns)):
            reference[columns[place]] -= (1.0 - _KEPT) * lead / square * normal[place]
