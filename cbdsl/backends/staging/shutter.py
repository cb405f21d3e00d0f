"""The shutter: times at which the cameras take images."""

from __future__ import annotations


class Shutter:
    """Opens at the cameras' rate, which need not divide the control rate.

    Args:
        rate: of the images, Hz.
        period: of control, s.
    """

    def __init__(self, rate: float, period: float) -> None:
        self._per_tick = rate * period

    def opens(self, tick: int) -> bool:
        """Whether the time for an image came within the last tick; the first is at tick 0."""
        # Images that are due by then, and a small share that keeps rounding from putting one off.
        due = tick * self._per_tick + 1e-6
        return tick == 0 or int(due) > int(due - self._per_tick)
