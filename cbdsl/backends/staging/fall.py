"""Detection of an object's fall from its place, and of its duration."""

from __future__ import annotations

import math

#: Depth below its place at which an object counts as fallen, m.
FALLEN = 0.2


class Fall:
    """One object that may fall from its place repeatedly.

    Args:
        height: Height of its place, m.
        delay: Delay after which it is put back, s.
    """

    def __init__(self, height: float, delay: float) -> None:
        self._lowest, self._delay = height - FALLEN, delay
        self._began = math.inf

    def is_due(self, height: float, time: float, *, touched: bool) -> bool:
        """Return whether it is time to put the object back.

        Args:
            height: Current height, m.
            time: Time since the episode began, s.
            touched: True if the robot touches the object; a carried object has not fallen.
        """
        if height > self._lowest or touched:
            self._began = math.inf
            return False
        self._began = min(self._began, time)
        return time - self._began >= self._delay
