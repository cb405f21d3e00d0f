"""Bounds of rows: levels that others below move only up to a value; compiled.

Model. A bound allows its row J the displacement s J d <= s a in a tick, with its side s. While the
levels above obey it, the row is idle, as if its level had no such row. The step of a level that
would pass the bound is shortened until it ends there. The row then joins the basis, and the level
goes on with the motion that remains. If the levels above pass the bound, its level requests the
displacement a like any other. Assumption: the set of reached bounds only grows within a tick. That
is optimal for bounds at right angles; at a corner of others, a level may move less than it could.
"""

from __future__ import annotations

from cbdsl.control.basis import Basis, span
from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.level import LevelArrays
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import copy, dot, fill

# Part of a way beyond a bound that is rounding.
_ROUNDING = 1e-12


@compiled
def leave_idle(
    levels: LevelArrays, level: int, start: int, total: Floats, middle: Floats, wanted: Floats
) -> int:
    """Leave out the rows of a level whose bounds the levels above obey; return how many act.

    Args:
        levels: Levels; ``idle`` is written.
        level: Number of the level; nothing is written if it does not act.
        start: Number of its first row.
        total: Displacement of the levels above, rad, shape (n,).
        middle: Rows of all levels, shape (k, n); those left out become 0.
        wanted: Requested displacement of all rows, shape (k,); the same.
    """
    acting = 0
    for row in range(start, levels.ends[level] if levels.ages[level] > 0 else start):
        side, request = levels.sides[row], levels.requested[row]
        levels.idle[row] = side != 0.0 and side * (dot(middle[row], total) - request) <= _ROUNDING
        if levels.idle[row]:
            fill(middle[row], 0.0)
            wanted[row] = 0.0
        else:
            acting += 1
    return acting


@compiled
def next_bound(
    levels: LevelArrays, end: int, rows: Floats, total: Floats, change: Floats
) -> tuple[int, float]:
    """Return the row of the first bound that a change meets, and the share of the change up to it.

    They are -1 and 1 without such a bound.

    Args:
        levels: Levels.
        end: The row after the last one of the level that moves.
        rows: Rows of all levels, shape (k, n).
        total: Displacement so far, rad, shape (n,).
        change: Displacement that the level adds, rad, shape (n,).
    """
    first, share = -1, 1.0
    for row in range(end):
        if levels.idle[row]:
            side = levels.sides[row]
            left = max(side * (levels.requested[row] - dot(rows[row], total)), 0.0)
            way = side * dot(rows[row], change)
            if way > left + _ROUNDING and left < share * way:
                first, share = row, left / way
    return first, share


@compiled
def hold_row(
    row: int, rows: Floats, levels: LevelArrays, basis: Basis, taken: int, middle: Floats,
    wanted: Floats, law: LawArrays,
) -> int:  # fmt: skip
    """Add a reached bound to the basis; return its number of directions.

    Args:
        row: Number of the row.
        rows: Rows of all levels, shape (k, n).
        levels: Levels.
        basis: Basis so far.
        taken: Number of its directions.
        middle: Rows of all levels that act, shape (k, n); gets the row back.
        wanted: Requested displacement of all rows, shape (k,); the same.
        law: Law, whose singular value of the row is written.
    """
    levels.idle[row], wanted[row] = False, levels.requested[row]
    copy(middle[row], rows[row], 1.0)
    for i in range(taken, len(basis.directions)):
        fill(basis.sides[i], 0.0)
    own, value = rows[row : row + 1], law.singular_values[row : row + 1]
    return taken + len(span(own, basis, taken, row, value))
