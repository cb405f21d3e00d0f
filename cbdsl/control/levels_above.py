"""Levels of bounds, above those of all controllers; compiled."""

from __future__ import annotations

import numpy as np

from cbdsl.control.composition import compose
from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.level import LevelArrays
from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.numeric.borrowed import borrow
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import copy


@compiled
def compose_below(
    rows: Floats,
    requested: Floats,
    ends: Integers,
    here: Floats,
    levels: LevelArrays,
    law: LawArrays,
) -> None:
    """Compose a displacement of all levels below others, which act in this tick alone.

    First order suffices for the levels above, because they act for a few ticks only.

    Args:
        rows: Rows of the levels above, shape (k, n).
        requested: Requested displacements of these rows, shape (k,).
        ends: Index after the last row of each of them, shape (levels,).
        here: Joint positions, rad, shape (n,).
        levels: Levels below, highest priority first.
        law: Bounds and guards; its result is overwritten.
    """
    first, above, newest = len(rows), len(ends), levels.clock[0]
    ticks, size, joints = levels.rows.shape
    count, total = above + len(levels.ends), first + size
    together, wanted = np.zeros((ticks, total, joints)), np.empty(total)
    for k in range(first):
        copy(together[newest, k], rows[k], 1.0)
        wanted[k] = requested[k]
    for k in range(size):
        for tick in range(ticks):
            copy(together[tick, first + k], levels.rows[tick, k], 1.0)
        wanted[first + k] = levels.requested[k]
    ages, last = np.ones(count, np.int64), np.empty(count, np.int64)
    for level in range(above):
        last[level] = ends[level]
    for level in range(above, count):
        ages[level] = levels.ages[level - above]
        last[level] = first + levels.ends[level - above]
    below = LevelArrays(
        np.full(1, newest), together, ages, wanted, last, np.ones(count), np.zeros(count),
        np.zeros(count, np.bool_), np.zeros((0, joints, joints)), np.zeros(count, np.int64),
        np.zeros(1, np.bool_), np.zeros(total), np.zeros(total, np.bool_),
    )  # fmt: skip
    copy(below.sides[first:], levels.sides, 1.0)
    values = np.zeros(total)
    own = LawArrays(law.limits, law.steps, law.guards, law.displacement, law.locked, borrow(values))
    compose(here, borrow(below), False, own)
    # The use of the levels after the composition keeps them alive until then.
    copy(law.singular_values, values[len(below.requested) - size :], 1.0)
    levels.idle[:] = below.idle[len(below.requested) - size :]
