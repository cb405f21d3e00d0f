"""Guard of distances: a level of bounds that keeps links apart; compiled.

Model. In the posture of the references, a near pair of links has the distance d and the slope n.
With the least distance c, a margin m and a share f, the displacement D of a tick has to obey

    n D >= -f (d - c - m)

so that pairs approach ever more slowly, and a pair that is too near parts. The law composes a
tick's displacement as if there were no bound. Some bounds push in the nearest displacement that
obeys all of them. These become a level of equations, and the law composes again, until all bounds
hold. Distances bend, above all where links pass each other. The references that follow are
therefore measured before they are commanded: if a pair would be nearer than c, and nearer than
before, all of them move a part of the way only. The motion that parts pairs is never shortened.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.law_arrays import LawArrays, bound_reference
from cbdsl.control.level import LevelArrays
from cbdsl.control.levels_above import compose_below
from cbdsl.kinematics.link_distance import DistanceArrays, measure, write_slope
from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import add, copy, dot, norm

# Violation of a bound, and of the least distance, that is rounding, m.
_ROUNDING, _EXACT = 1e-7, 1e-6
# Compositions in a tick, sweeps of a projection, and halvings of a step before it is left out.
_PASSES, _SWEEPS, _HALVES = 3, 60, 5


@compiled
def keep_apart(
    distances: DistanceArrays,
    references: Floats,
    here: Floats,
    columns: Integers,
    above: tuple[Floats, Floats, Integers],
    levels: LevelArrays,
    law: LawArrays,
) -> Floats:
    """Compose a displacement again that keeps links apart.

    Args:
        distances: Pairs of links; those of the references' posture are written.
        references: References of all joints, rad, shape (all,).
        here: Measured positions of the levels' joints, rad, shape (n,).
        columns: Joint index of each of the levels' n joints, shape (n,).
        above: Rows, requests and ends of the levels above the bounds, as in ``compose_below``.
        levels: Levels below, highest priority first.
        law: Bounds and guards, and the displacement; becomes the obedient displacement.

    Returns:
        The least displacement that obeys the bounds, rad, shape (n,): 0 unless links are too near.
    """
    rows, wanted, ends = above
    measure(distances, references)
    slopes, allowed, numbers = _bounds(distances, len(references), columns)
    held, obedient, parting = np.zeros(len(slopes), np.bool_), np.empty(len(columns)), here * 0.0
    _project(slopes, allowed, held, parting)
    held[:] = False
    for _ in range(_PASSES):
        copy(obedient, law.displacement, 1.0)
        if not _project(slopes, allowed, held, obedient):
            return parting
        size = len(rows)
        for k in range(len(held)):
            distances.pairs[numbers[k]].held = held[k]
            size += held[k]
        stacked, requested = np.empty((size, len(columns))), np.empty(size)
        for k in range(len(rows)):
            copy(stacked[k], rows[k], 1.0)
            requested[k] = wanted[k]
        size = len(rows)
        for k in range(len(held)):
            if held[k]:
                copy(stacked[size], slopes[k], 1.0)
                requested[size] = allowed[k]
                size += 1
        compose_below(stacked, requested, np.append(ends, size), here, levels, law)
    if math.isnan(law.displacement[0]):  # bounds that contradict each other
        copy(law.displacement, parting, 1.0)
    return parting


@compiled
def _bounds(
    distances: DistanceArrays, joints: int, columns: Integers
) -> tuple[Floats, Floats, Integers]:
    """Return slope (n,), least change in this tick, m, and number of each near pair that moves."""
    pairs, count = distances.pairs, 0
    least, share, margin = distances.bounds[0], distances.bounds[2], distances.bounds[3]
    for number in range(len(pairs)):
        pairs[number].held, pairs[number].before = False, pairs[number].distance
        count += pairs[number].near
    slopes, allowed = np.zeros((count, len(columns))), np.empty(count)
    numbers, whole, near = np.empty(count, np.int64), np.empty(joints), 0
    for number in range(len(pairs)):
        if pairs[number].near:
            write_slope(distances, number, whole)
            for place in range(len(columns)):
                slopes[near, place] = whole[columns[place]]
            left = pairs[number].distance - least - margin
            allowed[near] = min(-share * left, margin)
            numbers[near] = number
            near += norm(slopes[near]) > 0.0
    return slopes[:near], allowed[:near], numbers[:near]


@compiled
def _project(slopes: Floats, allowed: Floats, held: Booleans, displacement: Floats) -> bool:
    """Move a displacement to the nearest one that obeys all bounds; return whether it moved.

    Source: Hildreth's method, which corrects one bound after the other, and takes back a push that
    becomes needless.

    Args:
        slopes: Slopes of the distances, shape (k, n).
        allowed: Least changes of the distances in the tick, m, shape (k,).
        held: True for bounds that hold as equations already, shape (k,); becomes true for those
            that push the displacement.
        displacement: Displacement of the joints, shape (n,).
    """
    pressures, squares, is_moved = np.zeros(len(slopes)), np.empty(len(slopes)), False
    for k in range(len(slopes)):
        squares[k] = dot(slopes[k], slopes[k]) + 1e-12
    are_all = True
    for _ in range(_SWEEPS):
        most = 0.0
        for k in range(len(slopes)):
            # Between two sweeps of all bounds, only pushing bounds are corrected.
            if not held[k] and (are_all or pressures[k] > 0.0):
                lack = allowed[k] - dot(slopes[k], displacement)
                push = max(lack / squares[k], -pressures[k])
                if lack > _ROUNDING or push < 0.0:
                    pressures[k] += push
                    add(displacement, slopes[k], push)
                    most = max(most, abs(push) * squares[k])
        is_moved |= most > 0.0
        if most <= _ROUNDING and are_all:
            break
        are_all = most <= _ROUNDING
    for k in range(len(held)):
        held[k] |= pressures[k] > 0.0
    return is_moved


@compiled
def hold_back(
    distances: DistanceArrays,
    before: Floats,
    references: Floats,
    columns: Integers,
    parting: Floats,
    law: LawArrays,
) -> None:
    """Shorten the motion of references if it would bring links too near each other.

    Args:
        distances: Pairs of links, with their distances before the tick.
        before: References before the tick, rad, shape (all,).
        references: References after it; move back as far as they have to.
        columns: Joint index of each of the levels' n joints, shape (n,).
        parting: Part of the motion that brings links out of each other's way, rad, shape (n,). It
            is long where joints hardly change a distance.
        law: Bounds of the references.
    """
    pairs, steps = distances.pairs, np.empty(len(columns))
    for place in range(len(columns)):
        steps[place] = references[columns[place]] - before[columns[place]]
    for half in range(_HALVES + 1):
        measure(distances, references)
        is_clear = True
        for number in range(len(pairs)):
            least = min(pairs[number].before, distances.bounds[0]) - _EXACT
            is_clear &= pairs[number].distance >= least
        if is_clear:
            return
        share = 0.5 ** (half + 1) if half + 1 < _HALVES else 0.0
        for place in range(len(columns)):
            last, step = before[columns[place]], 0.0
            if half < _HALVES:
                step = parting[place] + share * (steps[place] - parting[place])
            references[columns[place]] = bound_reference(place, last, last + step, law)
