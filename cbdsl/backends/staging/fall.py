"""Whether something has fallen from where it was put, and for how long."""

from __future__ import annotations

import math

#: What is this far below where it was put has fallen, m.
FALLEN = 0.2


class Fall:
    """One thing that falls from its place, now and then.

    Args:
        height: of its place, m.
        delay: after how long it is to be put back, s.
    """

    def __init__(self, height: float, delay: float) -> None:
        self._lowest, self._delay = height - FALLEN, delay
        self._began = math.inf

    def is_due(self, height: float, time: float, *, touched: bool) -> bool:
        """Whether it is time to put it back.

        Args:
            height: where it is now, m.
            time: since the episode began, s.
            touched: whether the robot touches it; what a hand carries has not fallen.
        """
        if height > self._lowest or touched:
            self._began = math.inf
            return False
        self._began = min(self._began, time)
        return time - self._began >= self._delay
