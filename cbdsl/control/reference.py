"""References of joints, moved by the law's displacement within their bounds; compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cbdsl.control.composition import Booleans, Integers, compose
from cbdsl.control.load_guard import give_way
from cbdsl.control.signal import Floats
from cbdsl.numeric.compiled import compiled, compiled_once


@compiled_once
def move(
    reference: Floats,
    positions: Floats,
    columns: Integers,
    newest: int,
    rows: Floats,
    ages: Integers,
    wanted: Floats,
    ends: Integers,
    limits: Floats,
    guards: Floats,
    total: Floats,
    locked: Booleans,
    values: Floats,
    load_guards: Any,
    loads: Floats,
    table: Any,
    jacobian: Floats,
) -> bool:
    """Compose the displacement of all levels and move references (all,) by it, rad.

    Args:
        load_guards, loads, table, jacobian: as of ``load_guard.give_way``.
        positions: measured, of all joints, rad, shape (all,).
        columns: which joint each of the levels' n is, shape (n,).
        guards: largest displacement, largest damping, singular value below which damping sets in,
            and
            how far a reference may be from the position; else a blocked joint's would run away.

    The others are those of ``compose``.

    Returns:
        Whether all arguments were finite; otherwise nothing has moved.
    """
    here = np.empty(len(columns))
    for place in range(len(columns)):
        here[place] = positions[columns[place]]
    compose(
        here, newest, rows, ages, wanted, ends, limits, guards[0], guards[1], guards[2],
        total, locked, values,
    )  # fmt: skip
    if math.isnan(total[0]):
        return False
    if len(load_guards) > 0:
        give_way(
            load_guards, loads, table, jacobian, reference, here, columns, newest, rows, ages,
            wanted, ends, limits, guards, total, locked, values,
        )  # fmt: skip
    _advance(reference, columns, total, here, guards[3], limits)
    return True


@compiled
def _advance(
    reference: Floats,
    columns: Integers,
    displacement: Floats,
    here: Floats,
    lead: float,
    limits: Floats,
) -> None:
    """Move references of the joints ``columns`` (n,) by a displacement (n,), rad.

    A joint that is past one of its limits (2, n) comes back at the law's pace, not at once.
    """
    for place in range(len(columns)):
        before = reference[columns[place]]
        wanted = before + displacement[place]
        wanted = min(max(wanted, here[place] - lead), here[place] + lead)
        lowest, highest = min(limits[0, place], before), max(limits[1, place], before)
        reference[columns[place]] = min(max(wanted, lowest), highest)
