"""The four-valued state of a controller (Eq 4.1)."""

from __future__ import annotations

from collections import deque
from enum import StrEnum


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

    Raises:
        ValueError: ``rate`` or ``window`` is not positive.
    """

    def __init__(self, rate: float, window: float) -> None:
        if not (rate > 0 and window > 0):
            raise ValueError(f"rate {rate} and window {window} must be positive")
        self._largest_range = rate * window
        self._window = window
        self.reset()

    def reset(self) -> None:
        """Forget all values: the controller was deactivated."""
        self._time = 0.0
        self._times: deque[float] = deque()
        self._values: deque[float] = deque()
        self._predicate = Predicate.TRANSIENT

    def undefined(self) -> Predicate:
        """Note that the potential cannot be computed in this tick, and forget all values."""
        self.reset()
        return Predicate.UNDEFINED

    def update(self, phi: float, period: float, *, fresh: bool = True) -> Predicate:
        """Note the potential in one tick.

        Args:
            phi: the potential.
            period: time since the tick before, s.
            fresh: whether phi rests on a new measurement; otherwise it changes nothing.

        Returns:
            ``TRANSIENT`` or ``QUIESCENT``, as the newest measurement left it.
        """
        self._time += period
        if fresh:
            self._times.append(self._time)
            self._values.append(phi)
            self._predicate = self._judge()
        return self._predicate

    def _judge(self) -> Predicate:
        # Keep one value that is as old as the window, so that the rest spans all of it. Ticks add
        # up to a window but for rounding.
        start = self._time - self._window * (1 - 1e-9)
        while len(self._times) > 1 and self._times[1] <= start:
            self._times.popleft()
            self._values.popleft()
        most, values = self._largest_range, self._values
        # While it moves, the oldest and the newest value tell, whatever is between them.
        if self._times[0] > start or abs(values[-1] - values[0]) > most:
            return Predicate.TRANSIENT
        return Predicate.TRANSIENT if max(values) - min(values) > most else Predicate.QUIESCENT
