"""When the cameras take their images."""

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
        # The small shares keep rounding from putting an image off to the next tick.
        before, now = (int(each * self._per_tick + 1e-6) for each in (tick - 1, tick))
        return tick == 0 or now > before
