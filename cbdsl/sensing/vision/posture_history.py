"""Posture history: joint positions at the exposure of images that arrive later."""

from __future__ import annotations

from collections import deque

from cbdsl.numeric.arrays import Floats

# Time for which postures are kept, s; images must arrive with less delay.
_KEPT = 1.5
# Tolerance of times for rounding, s.
_SLACK = 1e-6


class PostureHistory:
    """Joint positions of the last ticks, back to the newest requested image, or 1.5 s."""

    def __init__(self) -> None:
        self._ticks: deque[tuple[float, Floats]] = deque()

    def reset(self) -> None:
        """Forget the episode before."""
        self._ticks.clear()

    def note(self, time: float, positions: Floats) -> None:
        """Add a tick's time, s, and joint positions, shape (n,), which must not be overwritten."""
        self._ticks.append((time, positions))
        if self._ticks[0][0] < time - _KEPT:
            self._ticks.popleft()

    def at(self, time: float) -> Floats:
        """Return joint positions, shape (n,), of the last tick up to a time, s, or the oldest."""
        ticks = self._ticks
        while len(ticks) > 1 and ticks[1][0] <= time + _SLACK:
            ticks.popleft()
        return ticks[0][1]
