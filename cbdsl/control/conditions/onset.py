"""Onset of contact: a change of a load from its initial mean; compiled.

A held object weighs on the load cells of the hand until something else supports it. The mean of the
load is that weight. The low-pass filtered change from it counts as contact after a minimum
duration. It counts only while the hand moves slowly, because acceleration also changes a load.

A hand that presses on a table, drags an object, or slips off it also measures a changed load. Three
conditions distinguish a support from these cases. First, before the change the hand bore a load
against its direction, as the weight of an object that hangs in the hand. Second, the load had no
component across the direction. A load that only the hand bears is vertical; a shared load is not.
Third, the hand has carried the load against the direction by some distance. Until all hold, the
mean follows. For objects that hang freely, the measured component across stays below 0.07 N.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import copy

#: Time constants of the filtered change and of the mean, s.
_QUICK, _SLOW = 0.05, 0.5

# Largest load across the direction of the change, as a share of the smallest borne load and of the
# load itself.
_ACROSS, _SLANT = 0.5, 0.02

#: State of a slot that waits for a change of its load.
ONSET = np.dtype(
    [
        ("change", np.float64),  # expected change
        ("along", np.float64, 3),  # direction of the change; 0 along axes that are not compared
        ("lasting", np.int64),  # ticks
        ("pace", np.float64),  # largest displacement of the tip in a tick
        ("tip", np.int64),  # row of the tip that carries the hand; -1 for none
        ("borne", np.float64),  # smallest mean load against the direction; -inf for none
        ("lifted", np.float64),  # distance that the tip has to carry it against the direction
        ("shares", np.float64, 2),  # weights of a new value, in the filtered load and in the mean
        ("drift", np.float64),  # largest change of the mean in a tick
        # Filtered load and its mean; last position of the tip; lowest place of the tip since the
        # load is borne, and its rise from there; ticks with a load, and ticks with a changed load.
        ("filtered", np.float64, 3),
        ("mean", np.float64, 3),
        ("last", np.float64, 3),
        ("lowest", np.float64),
        ("risen", np.float64),
        ("ticks", np.int64),
        ("changed", np.int64),
    ]
)


class OnsetForm(NamedTuple):
    """Constants of a change that a slot waits for.

    Attributes:
        change: Change of the load, N or N m.
        along: Unit vector of the change, world frame, shape (3,).
        window: Minimum duration of the change, s.
        pace: Speed of the tip above which no change counts, m/s.
        tip: Number of the row of the tip's position; -1 for none.
        period: Period of the control ticks, s.
        borne: Smallest mean load against ``along`` before the change, N or N m; -inf for none.
        lifted: Distance that the tip has to carry such a load against ``along``, m.
    """

    change: float
    along: Floats
    window: float
    pace: float
    tip: int
    period: float
    borne: float = -math.inf
    lifted: float = 0.0

    def record(self) -> tuple[Any, ...]:
        """Return an ``ONSET`` at rest."""
        lasting = max(1, round(self.window / self.period))
        shares = tuple(1.0 - math.exp(-self.period / time) for time in (_QUICK, _SLOW))
        still = (0.0, 0.0, 0.0)
        return (
            self.change, tuple(self.along), lasting, self.pace * self.period, self.tip,
            self.borne, self.lifted, shares, self.change * self.period, still, still, still,
            0.0, 0.0, 0, 0,
        )  # fmt: skip


@compiled
def restart_onset(onset: Any) -> None:
    """Forget the load."""
    onset.ticks = onset.changed = 0


@compiled
def note_load(onset: Any, load: Floats, tip: Floats) -> bool:
    """Process a load (3,) and the tip's position (3,); return whether the load has changed.

    After a change, no more loads must be noted before ``restart_onset``.
    """
    onset.ticks += 1
    moved = 0.0
    for i in range(len(tip)):
        moved += (tip[i] - onset.last[i]) ** 2
        onset.last[i] = tip[i]
    if onset.ticks == 1:
        # An initial load is not a change, however large it is.
        copy(onset.filtered, load, 1.0)
        copy(onset.mean, load, 1.0)
        onset.risen, onset.lowest = 0.0, math.inf
        return False
    # Initially a plain mean, without forgetting.
    quick = max(onset.shares[0], 1.0 / onset.ticks)
    slow = max(onset.shares[1], 1.0 / onset.ticks)
    change = 0.0
    for i in range(3):
        onset.filtered[i] += quick * (load[i] - onset.filtered[i])
        change += onset.along[i] * (onset.filtered[i] - onset.mean[i])
    is_carried = _is_carried(onset, tip)
    if is_carried and change >= onset.change and moved <= onset.pace * onset.pace:
        onset.changed += 1
        return bool(onset.changed >= onset.lasting)
    onset.changed = 0
    if is_carried:
        # The nearer to contact, the less the mean follows a possible onset.
        slow *= min(max(1.0 - change / onset.change, 0.0), 1.0)
    # The mean follows jolts slowly.
    drift = onset.drift if slow <= onset.shares[1] else math.inf
    for i in range(3):
        onset.mean[i] += min(max(slow * (load[i] - onset.mean[i]), -drift), drift)
    return False


@compiled
def _is_carried(onset: Any, tip: Floats) -> bool:
    """Track the rise of a load; return whether it hangs in the hand and was lifted."""
    bears, height, across = 0.0, 0.0, 0.0
    for i in range(3):
        bears -= onset.along[i] * onset.mean[i]
    for i in range(3):
        across += (onset.mean[i] + bears * onset.along[i]) ** 2
    for i in range(len(tip)):
        height -= onset.along[i] * tip[i]
    if bears < onset.borne:
        onset.lowest, onset.risen = math.inf, 0.0
        return False
    onset.lowest = min(onset.lowest, height)
    onset.risen = max(onset.risen, height - onset.lowest)
    if onset.borne > 0.0 and math.sqrt(across) > _ACROSS * onset.borne + _SLANT * bears:
        return False
    return bool(onset.risen >= onset.lifted)
