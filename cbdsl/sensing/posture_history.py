"""Posture history: where the joints were when an image was taken that is read later."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Ticks that are kept at most: a second or more at common rates.
_MOST = 256
# Rounding of times, s.
_SLACK = 1e-6


class PostureHistory:
    """Joint positions of the last ticks, back to the newest image that was asked for."""

    def __init__(self) -> None:
        self._ticks: deque[tuple[float, Floats]] = deque(maxlen=_MOST)

    def reset(self) -> None:
        """Forget the episode before."""
        self._ticks.clear()

    def note(self, time: float, positions: Floats) -> None:
        """Take in a tick: its time, s, and joint positions that nobody writes over, shape (n,)."""
        self._ticks.append((time, positions))

    def at(self, time: float) -> Floats:
        """The joint positions at a time, s, in the tick before, or the oldest known, shape (n,)."""
        ticks = self._ticks
        while len(ticks) > 1 and ticks[1][0] <= time + _SLACK:
            ticks.popleft()
        return ticks[0][1]
