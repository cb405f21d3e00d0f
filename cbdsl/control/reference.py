"""References of joints, moved by the law's displacement within their bounds; compiled."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.composition import compose
from cbdsl.control.distance_guard import hold_back, keep_apart
from cbdsl.control.law_arrays import LawArrays, bound_reference
from cbdsl.control.level import LevelArrays
from cbdsl.control.load_guard import give_way
from cbdsl.kinematics.link_distance import DistanceArrays
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled
from cbdsl.sensing.signal_arrays import SignalArrays

#: Outcomes of a move: the references have moved; the levels' Hessians are needed first; a number is
#: not finite.
ADVANCED, NEEDS_HESSIANS, NOT_FINITE = range(3)


@compiled
def move(
    references: Floats,
    joints: Integers,
    signals: SignalArrays,
    levels: LevelArrays,
    bends: bool,
    law: LawArrays,
    load_guards: Records,
    distances: DistanceArrays | None,
) -> int:
    """Compose the displacement of all levels and move references by it.

    Args:
        references: References of all joints, rad, shape (all,).
        joints: Joint index of each of the levels' n joints, shape (n,).
        signals: Arrays of the signals.
        levels: Levels, highest priority first.
        bends: True if the levels' Hessians are those of this tick.
        law: Bounds and guards; its result is overwritten.
        load_guards: Guards of loads, shape (g,) of ``load_guard.LOAD_GUARD``.
        distances: Pairs of links that keep a distance; ``None`` without a clearance, for which the
            guard of distances is not compiled.

    Returns:
        ``ADVANCED``; ``NEEDS_HESSIANS`` or ``NOT_FINITE`` if nothing has moved.
    """
    here = np.empty(len(joints))
    for place in range(len(joints)):
        here[place] = signals.sensed.positions[joints[place]]
    if compose(here, levels, bends, law):
        return NEEDS_HESSIANS
    if math.isnan(law.displacement[0]):
        return NOT_FINITE
    if distances is None:
        if len(load_guards) > 0:
            give_way(load_guards, signals, references, here, joints, levels, law)
        _advance(references, joints, here, law)
        return ADVANCED
    above = give_way(load_guards, signals, references, here, joints, levels, law)
    parting = keep_apart(distances, references, here, joints, above, levels, law)
    before = references.copy()
    _advance(references, joints, here, law)
    hold_back(distances, before, references, joints, parting, law)
    return ADVANCED


@compiled
def _advance(references: Floats, joints: Integers, here: Floats, law: LawArrays) -> None:
    """Move references by the law's displacement, rad.

    References keep within the lead of the positions ``here`` (n,) and within the limits, as far as
    the largest steps allow. A reference thus never jumps, even if a sensor does. Without the lead,
    the reference of a blocked joint would run away.
    """
    lead = law.guards[2]
    for place in range(len(joints)):
        before = references[joints[place]]
        after = before + law.displacement[place]
        after = min(max(after, here[place] - lead), here[place] + lead)
        references[joints[place]] = bound_reference(place, before, after, law)
