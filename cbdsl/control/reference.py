"""References of joints, moved by the law's displacement within their bounds; compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cbdsl.control.composition import compose
from cbdsl.control.level import LevelArrays
from cbdsl.control.load_guard import give_way
from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.numeric.compiled import compiled, compiled_once

#: Outcomes of a move: the references have moved; the levels' Hessians are needed first; a number is
#: not finite.
ADVANCED, NEEDS_HESSIANS, NOT_FINITE = range(3)


@compiled_once
def move(
    reference: Floats,
    positions: Floats,
    columns: Integers,
    newest: int,
    levels: LevelArrays,
    bends: bool,
    limits: Floats,
    steps: Floats,
    guards: Floats,
    total: Floats,
    locked: Booleans,
    values: Floats,
    load_guards: Any,
    loads: Floats,
    table: Any,
    jacobian: Floats,
) -> int:
    """Compose the displacement of all levels and move references by it.

    Args:
        reference: References of all joints, rad, shape (all,).
        positions: Measured positions of all joints, rad, shape (all,).
        columns: Joint index of each of the levels' n joints, shape (n,).
        guards: Guards of ``compose``, and the largest distance of a reference from the position.
            Without it, the reference of a blocked joint would run away.
        load_guards, loads, table, jacobian: Arguments of ``load_guard.give_way``.

    The other arguments are those of ``compose``.

    Returns:
        ``ADVANCED``; ``NEEDS_HESSIANS`` or ``NOT_FINITE`` if nothing has moved.
    """
    here = np.empty(len(columns))
    for place in range(len(columns)):
        here[place] = positions[columns[place]]
    if compose(here, newest, levels, bends, limits, steps, guards, total, locked, values):
        return NEEDS_HESSIANS
    if math.isnan(total[0]):
        return NOT_FINITE
    if len(load_guards) > 0:
        give_way(
            load_guards, loads, table, jacobian, reference, here, columns, newest, levels,
            limits, steps, guards, total, locked, values,
        )  # fmt: skip
    _advance(reference, columns, total, here, guards[2], limits, steps)
    return ADVANCED


@compiled
def _advance(
    reference: Floats,
    columns: Integers,
    displacement: Floats,
    here: Floats,
    lead: float,
    limits: Floats,
    steps: Floats,
) -> None:
    """Move references of the joints ``columns`` (n,) by a displacement (n,), rad.

    References keep within ``lead`` of the positions and within the limits (2, n), as far as the
    largest steps (n,) allow. A reference thus never jumps, even if a sensor does. A joint that is
    past one of its limits comes back at the law's pace.
    """
    for place in range(len(columns)):
        before = reference[columns[place]]
        after = before + displacement[place]
        after = min(max(after, here[place] - lead), here[place] + lead)
        after = min(max(after, min(limits[0, place], before)), max(limits[1, place], before))
        after = min(max(after, before - steps[place]), before + steps[place])
        reference[columns[place]] = after
