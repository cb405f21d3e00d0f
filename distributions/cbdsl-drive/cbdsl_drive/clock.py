"""Clock: the times that a driven robot is checked against."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple


class Clock(NamedTuple):
    """Clocks of this computer; tests have their own.

    Attributes:
        monotonic: Time that never jumps, s.
        wall: Time since the epoch, s, as messages are stamped.
        sleep: Function that waits for some seconds.
    """

    monotonic: Callable[[], float] = time.monotonic
    wall: Callable[[], float] = time.time
    sleep: Callable[[float], None] = time.sleep

    @property
    def is_real(self) -> bool:
        """True if the times are those of this computer."""
        return self == Clock()
