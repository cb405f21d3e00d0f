"""A measured quantity beside what the source reports, and a verdict that its interval gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from cbdsl.reproduction.claim import Claim, Interval

# A process of which the claim is false may pass this often; else there are too few trials.
_CHANCE = 0.05


class Verdict(StrEnum):
    """How our number stands beside the source's."""

    REPRODUCED = "reproduced"
    ORDERING = "ordering only"
    UNDECIDED = "undecided"
    MISSED = "missed"
    NOT_JUDGED = "not judged"


@dataclass(frozen=True)
class Quantity:
    """One number of an experiment.

    Attributes:
        name: what was measured.
        unit: of ``ours``; empty for a bare number.
        source: what the source reports, in a few words of our own.
        ours: what we measured; NaN where it could not be, which is a miss.
        expected: the region that the source's words put it in; ``None`` where nothing is claimed.
        ordering: the region of at least the order that the source reports, where that says less.
        interval: 95 % interval of ``ours``, both ends ``ours`` where it is computed rather than
            sampled, ``None`` where a single trial tells no spread.
        chance: how likely a process of which ``expected`` is only just false would be called
            reproduced with as many trials; 0 where nothing is sampled.
        note: what a reader must know to judge it.
    """

    name: str
    unit: str
    source: str
    ours: float
    expected: Claim | None
    ordering: Claim | None = None
    interval: Interval | None = None
    chance: float = 0.0
    note: str = ""

    @property
    def verdict(self) -> Verdict:
        """The verdict of the claims on the interval."""
        if self.expected is None:
            return Verdict.NOT_JUDGED
        if math.isnan(self.ours):
            return Verdict.MISSED
        if self.interval is None:
            return Verdict.NOT_JUDGED
        if self.chance <= _CHANCE and self.expected.contains(self.interval):
            return Verdict.REPRODUCED
        if self.ordering is not None and self.ordering.contains(self.interval):
            return Verdict.ORDERING
        if self.expected.excludes(self.interval):
            return Verdict.MISSED
        return Verdict.UNDECIDED


def computed(
    name: str, unit: str, source: str, ours: float, expected: Claim, *, note: str = ""
) -> Quantity:
    """A quantity without spread: it is computed, or measured where nothing is random."""
    interval = None if math.isnan(ours) else (ours, ours)
    return Quantity(name, unit, source, ours, expected, interval=interval, note=note)
