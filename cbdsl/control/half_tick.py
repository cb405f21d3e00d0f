"""Jacobians of the middle of a tick, extrapolated from three ticks; compiled.

With the Jacobians at the start of a tick, a lower level moves those above by the square of its
step. With those at its middle, it moves them by the cube.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.level import LevelArrays
from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import dot, fill


@compiled
def write_middle(positions: Floats, levels: LevelArrays, bends: bool, middle: Floats) -> bool:
    """Write the rows of active levels; return whether all numbers are finite.

    They are those of the middle of the tick, or of its start if Hessians say how they change: at a
    singularity, extrapolation enlarges each alternation of the rows up to 3.5 times.

    Args:
        positions: Joint positions, rad, shape (n,).
        levels: Levels, highest priority first.
        bends: True if the levels' Hessians are those of this tick.
        middle: Becomes the rows, shape (k, n), 0 for levels that do not act.
    """
    ages, ends, requested = levels.ages, levels.ends, levels.requested
    squares = dot(positions, positions)
    start = 0
    for level in range(len(ends)):
        end = ends[level]
        for row in range(start, end):
            fill(middle[row], 0.0)
        if ages[level] > 0:
            age = 1 if bends else ages[level]
            _extrapolate(levels.rows, levels.clock[0], age, start, end, middle)
            for row in range(start, end):
                squares += dot(middle[row], middle[row]) + requested[row] * requested[row]
        start = end
    return math.isfinite(squares)


@compiled_once
def extrapolate_half_tick(rows: Floats, newest: int, ages: Integers, ends: Integers) -> Floats:
    """Return rows half a tick ahead, shape (k, n), 0 for levels that do not act."""
    middle = np.zeros(rows.shape[1:])
    start = 0
    for level in range(len(ends)):
        end = ends[level]
        if ages[level] > 0:
            _extrapolate(rows, newest, ages[level], start, end, middle)
        start = end
    return middle


@compiled
def _extrapolate(rows: Floats, newest: int, age: int, start: int, end: int, middle: Floats) -> None:
    """Extrapolate half a tick ahead from up to three ticks: parabola, line or constant."""
    now, before, earlier = rows[newest], rows[newest - 1], rows[newest - 2]
    for row in range(start, end):
        for joint in range(rows.shape[2]):
            middle[row, joint] = now[row, joint]
            if age == 2:
                middle[row, joint] += 0.5 * (now[row, joint] - before[row, joint])
            elif age > 2:
                middle[row, joint] += (
                    0.875 * now[row, joint]
                    - 1.25 * before[row, joint]
                    + 0.375 * earlier[row, joint]
                )
