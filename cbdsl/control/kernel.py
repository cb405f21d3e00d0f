"""One controller's tick, all at once: from its feedback to its level in the stack; compiled.

Called one by one, the steps would take less time than the calls of them.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.composition import Integers
from cbdsl.control.manipulability import volume
from cbdsl.control.potential import ALIGNMENT, RANGE, SPRING
from cbdsl.control.predicate import ROOM, note
from cbdsl.control.range import turn
from cbdsl.control.rate import displace, norm
from cbdsl.control.signal import Floats
from cbdsl.control.spring import aim, subtract
from cbdsl.control.stack import TICKS
from cbdsl.numeric.compiled import compiled, compiled_once

#: What a member does in a tick: nothing; follow its reference; the same while its predicate stays
#: undefined; nothing more, since it was evaluated by itself.
REST, FOLLOW, SEEK, DONE = range(4)

# What a plan has: the potential's kind, task coordinates, components of the feedback, rows of its
# Jacobian, whether it is the posture of the sources, what to do in this tick, and the stamp of the
# newest measurement.
KIND, SIZE, COMPONENTS, ROWS, IS_POSTURE, DUTY, STAMP = range(7)

# What an outcome has: phi, the norm of the residual, and how far above its reference a position
# is sent to, m.
PHI, ERROR, RAISED = range(3)


@compiled_once
def act_all(
    first: int,
    last: int,
    positions: Floats,
    posture: int,
    newest: int,
    rows: Floats,
    wanted: Floats,
    ages: Integers,
    starts: Integers,
    plans: Integers,
    constants: Floats,
    sources: Integers,
    values: Floats,
    references: Floats,
    jacobians: Floats,
    outcomes: Floats,
    bounds: Floats,
    before: Floats,
    settings: Floats,
    windows: Floats,
    notes: Integers,
    members: Integers,
    columns: Integers,
) -> int:
    """Let the members of a composition act, from the first up to the last.

    Args:
        positions: of all actuated joints, rad, shape (joints,).
        posture: stamp of the positions.
        newest, rows, wanted, ages, starts: of the stack.
        plans, constants, sources, values, references, jacobians, outcomes: of all members, in
            rows: see ``Member``.
        bounds, before: of their tasks.
        settings, windows, notes: of their monitors.
        members: the rows of those that act, highest priority first.
        columns: which joint each of the stack's n is for them, shape (members, n).

    Returns:
        ``last``, or the place of a member that could not act, as ``act`` has it.
    """
    no_curvature = np.empty((0, 0, 0))
    for place in range(first, last):
        row = members[place]
        plan = plans[row]
        if plan[DUTY] == REST:
            ages[place] = 0
        if plan[DUTY] not in (FOLLOW, SEEK):
            continue
        if plan[IS_POSTURE]:
            plan[STAMP] = posture
            for i in range(plan[COMPONENTS]):
                values[row, i] = positions[sources[row, i]]
        phi, error = act(
            plan[KIND],
            constants[row],
            values[row, : plan[COMPONENTS]],
            jacobians[row, : plan[ROWS]],
            no_curvature,
            references[row, : plan[COMPONENTS]],
            outcomes[row, RAISED],
            newest,
            bounds[row],
            before[row, : plan[SIZE]],
            columns[place],
            rows,
            wanted,
            ages,
            starts[place],
            place,
        )
        if math.isnan(phi):
            return place
        if plan[DUTY] == FOLLOW:
            outcomes[row, PHI], outcomes[row, ERROR] = phi, error
            note(phi, plan[STAMP], settings[row], windows[row, : notes[row, ROOM]], notes[row])
    return last


@compiled_once
def act(
    kind: int,
    constants: Floats,
    value: Floats,
    jacobian: Floats,
    curvature: Floats,
    reference: Floats,
    raised: float,
    newest: int,
    bounds: Floats,
    before: Floats,
    columns: Integers,
    rows: Floats,
    wanted: Floats,
    ages: Integers,
    start: int,
    place: int,
) -> tuple[float, float]:
    """Evaluate a potential and let its controller act.

    Args:
        kind: of the potential, as ``Compiled`` has it.
        constants: of the potential.
        value: of the feedback, shape (m,); a rotation row by row, shape (9,).
        jacobian: of the feedback by all joints, shape (m, all).
        curvature: derivative of the Jacobian, shape (m, all, all), or empty.
        reference: what the feedback shall become, shaped like its value.
        raised: how far above its reference a position is sent to, m.
        newest: of the stack.
        bounds: see ``bounds_of``.
        before: what the task moved by in the tick before, shape (k,); becomes this tick's.
        columns: which joint each of the stack's n is, -1 for those that count as still.
        rows, wanted, ages: of the stack.
        start: the level's first row in the stack.
        place: of the level in the stack.

    Returns:
        phi and the residual's norm; NaN, and nothing acts, where something is missing, misshapen
        or not finite, or manipulability is near a singularity.
    """
    level = rows[newest, start : start + len(before)]
    residual, scale = np.empty(len(before)), 1.0
    if kind in (SPRING, RANGE):
        if not len(value) == len(jacobian) == len(before):
            return math.nan, math.nan
        _select(jacobian, columns, level)
        if kind == RANGE:
            phi = turn(value, constants, residual, level)
        else:
            phi = subtract(value, reference, residual)
        error = norm(residual)
        if raised > 0.0:
            residual[2] += raised
        step = 0.5 * residual
    elif kind == ALIGNMENT:
        if not (len(value) == len(reference) == 9 and len(jacobian) == 3):
            return math.nan, math.nan
        others, turning = np.empty((2, 3)), np.empty((3, len(columns)))
        phi = aim(value, reference, int(constants[0, 0]), residual, others)
        error = norm(residual)
        step = 0.5 * residual
        _select(jacobian, columns, turning)
        level[:] = 0.0
        for row in range(2):
            for part in range(3):
                level[row] += others[row, part] * turning[part]
    else:
        phi = -volume(jacobian, curvature, columns, level[0])
        length = norm(level[0])
        error = length * length
        residual[0] = -error
        step = residual
        # Down the slope, as a unit vector, like any potential without a residual.
        scale = 1.0 / length if length > 0.0 else 0.0
        level[0] *= -scale
    sound = math.isfinite(phi + np.sum(level * 0.0))
    if not (sound and displace(step, residual, level, scale, bounds, before)):
        return math.nan, math.nan
    wanted[start : start + len(before)] = before
    ages[place] = min(ages[place] + 1, TICKS)
    return phi, error


@compiled
def _select(jacobian: Floats, columns: Integers, level: Floats) -> None:
    """Columns of a Jacobian (m, all); one that is numbered -1 is 0."""
    for place in range(len(columns)):
        column = columns[place]
        for row in range(len(jacobian)):
            level[row, place] = jacobian[row, column] if column >= 0 else 0.0
