"""Clearance of a run: the pairs of links that keep a distance, and how long each was held."""

from __future__ import annotations

from collections import Counter

import numpy as np

from cbdsl.diagnostics.counting import some
from cbdsl.kinematics.link_clearance import FAR, LinkClearance, with_places
from cbdsl.kinematics.link_distance import DistanceArrays
from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.program.checked import Guards
from cbdsl.sensing.signals import Signals

# Distance beyond the clearance within which links slow down, m, and the time constant, s.
_NEAR, _TIME = 0.06, 0.15
# Speed at which links part that are too near, m/s; their way in a tick is the margin.
_PACE = 0.06
# Largest share of the way to the clearance in a tick.
_MOST = 0.5


class Clearance:
    """Bound on the distances between the links of a robot.

    Attributes:
        arrays: Shapes and pairs of links; ``None`` without a bound.
        rows: Rows of the signal table of the seen objects that links keep away from.

    Args:
        guards: Guards, whose least distance counts if that of the robot is less.
        signals: Signals of the robot.
        period: Period of the control ticks, s.
    """

    def __init__(self, guards: Guards, signals: Signals, period: float) -> None:
        self._period, self._held = period, Counter[tuple[str, str]]()
        self._least = least = max(guards.clearance or 0.0, signals.robot.clearance.distance or 0.0)
        self._table, self.rows = signals.table, [signals.bind(each) for each in guards.seen]
        self._balls = [each.name for each in guards.seen]
        self._links: LinkClearance | None = None
        if least > 0.0:
            share = min(period / _TIME, _MOST)
            model = signals.kinematics.model
            robot = with_places(signals.robot, {**guards.hulls, **dict.fromkeys(self._balls, FAR)})
            self._links = LinkClearance(robot, model, least, _NEAR, share, _PACE * period)
        self.arrays: DistanceArrays | None = self._links.arrays if self._links else None

    def reset(self) -> None:
        """Forget the last episode."""
        self._held.clear()
        if self._links is not None:
            self._links.arrays.pairs["held"] = False

    def place_seen(self) -> None:
        """Move the balls of seen objects to their measured places; those not seen are far away."""
        if self._links is None or not self.rows:
            return
        for row, name in zip(self.rows, self._balls, strict=True):
            if self._table.is_defined(row):
                radius = float(self._table.records[row]["radius"])
                self._links.place(name, self._table.values(row), radius)
            else:
                self._links.place(name, np.array(FAR.points[0]), 0.0)

    def note(self) -> None:
        """Count the ticks in which pairs were held."""
        if self._links is not None and self._links.arrays.pairs["held"].any():
            self._held.update(set(self._pairs))

    @property
    def _pairs(self) -> list[tuple[str, str]]:
        """Pairs of links that the last tick held apart."""
        if self._links is None:
            return []
        names, held = self._links.names, self._links.arrays.pairs["held"]
        return [names[number] for number in np.flatnonzero(held)]

    @property
    def holding(self) -> tuple[str, ...]:
        """Descriptions of the pairs of links that the last tick held apart."""
        return tuple(dict.fromkeys(f"{one} near {other}" for one, other in self._pairs))

    def pressing(self, joints: Integers) -> dict[str, Floats]:
        """Return the decrease of the distance of each pair that was held apart per joint.

        Args:
            joints: Indices of joints among the actuated ones, shape (n,).

        Returns:
            Rows of shape (n,), by a clause about the pair.
        """
        links, rows = self._links, dict[str, Floats]()
        if links is None:
            return rows
        pairs = links.arrays.pairs
        for number in np.flatnonzero(pairs["held"] & pairs["near"]).tolist():
            one, other = links.names[number]
            distance = 100 * float(pairs["distance"][number])
            rows[f"{one} from {other} ({distance:.1f} cm)"] = -links.slope(number)[joints]
        return rows

    @property
    def clauses(self) -> tuple[str, ...]:
        """Clause about the pairs that were held apart, those for longest first; or none."""
        held = [
            f"{one} from {other} for {ticks * self._period:.1f} s"
            for (one, other), ticks in self._held.most_common()
        ]
        return (f"the clearance of {100 * self._least:g} cm held {some(held)}",) if held else ()
