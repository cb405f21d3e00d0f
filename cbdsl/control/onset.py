"""Onset of contact: a load that has changed from what it was at first; compiled.

What a hand holds weighs on its load cells until something else bears it. The mean of the load is
that weight. The change from it, low-pass filtered, counts as contact once it has lasted, and only
while the hand moves slowly: a load that is accelerated changes, too.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cbdsl.control.signal import Floats
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import copy

#: Time in which a change is filtered, and in which the mean forgets, s.
_QUICK, _SLOW = 0.05, 0.5

#: The state of a slot that waits for a change of its load.
ONSET = np.dtype(
    [
        ("change", np.float64),  # that is waited for
        ("along", np.float64, 3),  # direction of the change; 0 along axes that are not compared
        ("lasting", np.int64),  # ticks
        ("pace", np.float64),  # most displacement of the tip in a tick
        ("tip", np.int64),  # row of the tip that carries the hand; -1 for none
        ("shares", np.float64, 2),  # of a new value, in the filtered load and in the mean
        ("drift", np.float64),  # most that the mean follows in a tick
        # The load, filtered and in the mean; where the tip was; for how many ticks there has been a
        # load, and for how many it has been another.
        ("filtered", np.float64, 3),
        ("mean", np.float64, 3),
        ("last", np.float64, 3),
        ("ticks", np.int64),
        ("changed", np.int64),
    ]
)


class OnsetForm(NamedTuple):
    """Constants of a change that a slot waits for.

    Attributes:
        change: of the load, N or N m.
        along: unit vector of the change, world frame, shape (3,).
        window: for how long it has to last, s.
        pace: speed of the tip above which no change counts, m/s.
        tip: number of the row of the tip's position; -1 for none.
        period: of the control ticks, s.
    """

    change: float
    along: Floats
    window: float
    pace: float
    tip: int
    period: float

    def record(self) -> tuple[Any, ...]:
        """An ``ONSET`` at rest."""
        lasting = max(1, round(self.window / self.period))
        shares = tuple(1.0 - math.exp(-self.period / time) for time in (_QUICK, _SLOW))
        still = (0.0, 0.0, 0.0)
        return (
            self.change, tuple(self.along), lasting, self.pace * self.period, self.tip, shares,
            self.change * self.period, still, still, still, 0, 0,
        )  # fmt: skip


@compiled
def restart_onset(onset: Any) -> None:
    """Forget the load."""
    onset.ticks = onset.changed = 0


@compiled
def note_load(onset: Any, load: Floats, tip: Floats) -> bool:
    """Take in a load (3,) and the position of the tip (3,); returns whether the load has changed.

    From then on nothing is to be noted before ``restart_onset``.
    """
    onset.ticks += 1
    moved = 0.0
    for i in range(len(tip)):
        moved += (tip[i] - onset.last[i]) ** 2
        onset.last[i] = tip[i]
    if onset.ticks == 1:
        # A load that is there from the beginning has not changed, however large it is.
        copy(onset.filtered, load, 1.0)
        copy(onset.mean, load, 1.0)
        return False
    # At first a plain mean: it has nothing to forget.
    quick = max(onset.shares[0], 1.0 / onset.ticks)
    slow = max(onset.shares[1], 1.0 / onset.ticks)
    change = 0.0
    for i in range(3):
        onset.filtered[i] += quick * (load[i] - onset.filtered[i])
        change += onset.along[i] * (onset.filtered[i] - onset.mean[i])
    if onset.ticks > 1 and change >= onset.change and moved <= onset.pace * onset.pace:
        onset.changed += 1
        return bool(onset.changed >= onset.lasting)
    onset.changed = 0
    # The nearer to contact, the less the mean follows what may become one. Jolts it follows slowly.
    slow *= min(max(1.0 - change / onset.change, 0.0), 1.0)
    drift = onset.drift if slow <= onset.shares[1] else math.inf
    for i in range(3):
        onset.mean[i] += min(max(slow * (load[i] - onset.mean[i]), -drift), drift)
    return False
