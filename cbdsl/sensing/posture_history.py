"""Posture history: where the joints were when an image was taken that is read later."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# How long postures are kept, s: no image may be as late.
_KEPT = 1.5
# Rounding of times, s.
_SLACK = 1e-6


class PostureHistory:
    """Joint positions of the last ticks, back to the newest image that was asked for, or 1.5 s."""

    def __init__(self) -> None:
        self._ticks: deque[tuple[float, Floats]] = deque()

    def reset(self) -> None:
        """Forget the episode before."""
        self._ticks.clear()

    def note(self, time: float, positions: Floats) -> None:
        """Take in a tick: its time, s, and joint positions that nobody writes over, shape (n,)."""
        self._ticks.append((time, positions))
        if self._ticks[0][0] < time - _KEPT:
            self._ticks.popleft()

    def at(self, time: float) -> Floats:
        """The joint positions at a time, s, in the tick before, or the oldest known, shape (n,)."""
        ticks = self._ticks
        while len(ticks) > 1 and ticks[1][0] <= time + _SLACK:
            ticks.popleft()
        return ticks[0][1]
