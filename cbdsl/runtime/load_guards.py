"""Guards of a run: which they are, how long the motion gave way to each, and at which force."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.load_guard import LOAD_GUARD, PACE
from cbdsl.program.checked import Guards
from cbdsl.sensing.signals import Signals


class LoadGuards:
    """The bounds on fingers and hands that a program states.

    Attributes:
        names: of the fingers and hands.
        records: shape (g,) of ``LOAD_GUARD``.
        rows: of the signal table that they need.

    Args:
        guards: of the program.
        signals: of the robot.
        period: of the control ticks, s.
    """

    def __init__(self, guards: Guards, signals: Signals, period: float) -> None:
        self._period = period
        self.names: list[str] = []
        records = []
        for name, cells, row, bound in _bounds(guards, signals):
            self.names.append(name)
            records.append((*cells, row, bound, PACE * period, 0.0, False))
        self.records: NDArray[Any] = np.array(records, LOAD_GUARD)
        self.rows = self.records["row"].tolist()
        self.reset()

    def reset(self) -> None:
        """Forget the episode before."""
        self.records["held"] = False
        self._ticks = np.zeros(len(self.names), dtype=np.int64)
        self._most = np.zeros(len(self.names))

    def note(self) -> None:
        """Take in what the tick made of them."""
        if self.names:
            self._ticks += self.records["held"]
            np.maximum(self._most, self.records["force"], out=self._most)

    @property
    def holding(self) -> tuple[str, ...]:
        """Names of those that the motion gave way to in the last tick."""
        return tuple(np.array(self.names)[self.records["held"]].tolist())

    @property
    def clauses(self) -> tuple[str, ...]:
        """For each that the motion gave way to, how long and at most at which force."""
        rows = zip(self.names, self.records["bound"], self._ticks, self._most, strict=True)
        return tuple(
            f"the guard of {name} ({bound:g} N) held for {ticks * self._period:.1f} s, at "
            f"{most:.1f} N at most"
            for name, bound, ticks, most in rows
            if ticks
        )


def _bounds(guards: Guards, signals: Signals) -> Iterator[tuple[str, tuple[int, int], int, float]]:
    """Name, load cells, row and bound of each guard."""
    for hand, cells in signals.robot.load_cells.items():
        first, last = signals.touch.span(hand)
        links = [cell.link for cell in cells.values()]
        if guards.finger_force is not None:
            for place, (finger, link) in enumerate(zip(cells, links, strict=True), first):
                row = signals.bind_links([link])
                yield f"{hand}.{finger}", (place, place + 1), row, guards.finger_force
        if guards.hand_force is not None:
            yield hand, (first, last), signals.bind_links(links), guards.hand_force
