"""Bounds of the joints' displacements in a tick; compiled."""

from __future__ import annotations

import numpy as np

from cbdsl.control.law_arrays import LawArrays
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled

# Bounds are this much wider, rad, so that rounding never counts as passing one.
_SLACK = 1e-12

# Largest share of a change that does not count as all of it.
_MOST = 1.0 - 1e-15


@compiled
def displacement_bounds(positions: Floats, law: LawArrays) -> Floats:
    """Return the least and the largest displacement of each joint, shape (2, n).

    Limits take precedence over the levels' requests, and the largest step over limits.
    """
    limits, steps = law.limits, law.steps
    bounds = np.empty(limits.shape)
    for joint in range(len(positions)):
        step = steps[joint]
        lowest = limits[0, joint] - positions[joint] - _SLACK
        highest = limits[1, joint] - positions[joint] + _SLACK
        bounds[0, joint] = max(min(lowest, step), -step - 2 * _SLACK)
        bounds[1, joint] = min(max(highest, -step), step + 2 * _SLACK)
    return bounds


@compiled
def keep_within(total: Floats, bounds: Floats) -> None:
    """Move each joint's displacement (n,) into its bounds (2, n)."""
    for joint in range(len(total)):
        total[joint] = min(max(total[joint], bounds[0, joint]), bounds[1, joint])


@compiled
def shorten(change: Floats, law: LawArrays, bounds: Floats) -> None:
    """Shorten a change as a whole so that every joint keeps within its largest step."""
    total, locked, steps = law.displacement, law.locked, law.steps
    share, exceeds = 1.0, False
    for joint in range(len(change)):
        if locked[joint]:
            change[joint] = 0.0  # exact, because rounding could look like passing a bound
        target = total[joint] + change[joint]
        exceeds |= target < bounds[0, joint] or target > bounds[1, joint]
        size = abs(change[joint])
        ahead = total[joint] if change[joint] > 0.0 else -total[joint]
        left = max(steps[joint] + _SLACK - ahead, 0.0)
        if size > left + _SLACK:
            share = min(share, left / size)
    if exceeds:
        for joint in range(len(change)):
            change[joint] *= share


@compiled
def go(change: Floats, share: float, law: LawArrays, bounds: Floats) -> bool:
    """Add a share of a change, at most up to the first bound of a joint, and lock joints there.

    A joint beyond a limit is locked on its way back inside.

    Returns:
        True if a joint was locked.
    """
    total, locks = law.displacement, False
    for joint in range(len(change)):
        room = _room(total[joint], change[joint], bounds[:, joint])
        if room < 1.0 and room <= share:
            share, locks = room, True
    for joint in range(len(change)):
        stops = locks and _room(total[joint], change[joint], bounds[:, joint]) <= share
        total[joint] += share * change[joint]
        if stops:
            law.locked[joint] = True
            total[joint] = min(max(total[joint], bounds[0, joint]), bounds[1, joint])
    return locks


@compiled
def _room(before: float, change: float, bounds: Floats) -> float:
    """Return the share of a joint's change that is within its bounds; 1 only if all of it is."""
    after = before + change
    if bounds[0] <= after <= bounds[1]:
        return 1.0
    bound = bounds[1] if after > bounds[1] else bounds[0]
    return min(max((bound - before) / change, 0.0), _MOST) if change != 0.0 else 0.0
