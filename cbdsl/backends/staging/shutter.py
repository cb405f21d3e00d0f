"""Shutter: times at which the cameras take images."""

from __future__ import annotations


class Shutter:
    """Shutter that opens at the cameras' rate, which need not divide the control rate.

    Args:
        rate: Image rate, Hz.
        period: Control period, s.
    """

    def __init__(self, rate: float, period: float) -> None:
        self._per_tick = rate * period

    def opens(self, tick: int) -> bool:
        """Return whether an image became due within the last tick; the first is due at tick 0."""
        # Number of images due by then; a small share keeps rounding from delaying one.
        due = tick * self._per_tick + 1e-6
        return tick == 0 or int(due) > int(due - self._per_tick)
