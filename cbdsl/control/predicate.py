"""The four-valued state of a controller (Eq 4.1)."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from cbdsl.robot.compiled import compiled_once

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Predicate(StrEnum):
    """What a controller's potential does; its values join into states such as ``X0-``."""

    INACTIVE = "X"
    UNDEFINED = "-"
    TRANSIENT = "0"
    QUIESCENT = "1"


class QuiescenceMonitor:
    """Tells whether a potential is at rest: its range over a window, per second of the window.

    The range, not the derivative at an instant, since the latter flips with every ripple of the
    signal. Only measured values enter it: a potential that is repeated between two camera images
    is not at rest for that. Time passes with every tick all the same.

    Args:
        rate: largest range per second at rest, in the potential's unit per second (epsilon).
        window: how long the potential is watched, s; at rest needs a window that is full.
        period: time between ticks, s.

    Raises:
        ValueError: ``rate``, ``window`` or ``period`` is not positive.
    """

    def __init__(self, rate: float, window: float, period: float) -> None:
        if not (rate > 0 and window > 0 and period > 0):
            raise ValueError(f"rate {rate}, window {window} and period {period} must be positive")
        self._largest_range = rate * window
        self._window = window
        self._period = period
        # One value is as old as the window or older, the others are within.
        self._values = np.zeros((2, math.ceil(window / period) + 2))
        self._kept = np.zeros(2, dtype=np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget all values: the controller was deactivated."""
        self._ticks = 0
        self._kept[:] = 0
        self._predicate = Predicate.TRANSIENT

    def undefined(self) -> Predicate:
        """Note that the potential cannot be computed in this tick, and forget all values."""
        if self._ticks:
            self.reset()
        return Predicate.UNDEFINED

    def update(self, phi: float, *, fresh: bool = True) -> Predicate:
        """Note the potential in one tick.

        Args:
            phi: the potential.
            fresh: whether phi rests on a new measurement; otherwise it changes nothing.

        Returns:
            ``TRANSIENT`` or ``QUIESCENT``, as the newest measurement left it.
        """
        self._ticks += 1
        if fresh:
            time = self._ticks * self._period
            rests = _note(self._values, self._kept, time, phi, self._window, self._largest_range)
            self._predicate = Predicate.QUIESCENT if rests else Predicate.TRANSIENT
        return self._predicate


@compiled_once
def _note(
    values: Floats, kept: Integers, time: float, phi: float, window: float, largest_range: float
) -> bool:
    """Note a potential; returns whether it is at rest.

    Args:
        values: times, s, above potentials, round and round, shape (2, n).
        kept: where the oldest is, and how many there are.
        time: now, s.
        phi: the potential.
        window: how long it is watched, s.
        largest_range: in the window, at rest.
    """
    length = values.shape[1]
    newest = (kept[0] + kept[1]) % length
    values[0, newest], values[1, newest] = time, phi
    kept[1] += 1
    # Keep one value that is as old as the window, so that the rest spans all of it. Ticks add up
    # to a window but for rounding.
    start = time - window * (1.0 - 1e-9)
    while kept[1] > 1 and values[0, (kept[0] + 1) % length] <= start:
        kept[0] = (kept[0] + 1) % length
        kept[1] -= 1
    if values[0, kept[0]] > start:
        return False
    least = most = phi
    for i in range(kept[1]):
        value = values[1, (kept[0] + i) % length]
        least, most = min(least, value), max(most, value)
    return most - least <= largest_range
