"""Measured quantity beside the value of the source, and the verdict that its interval gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from cbdsl_reproduction.claim import Claim, Interval

# Probability below which trials of the same process hardly ever differ as much.
_DOUBT = 0.05
# Largest probability that a process that violates the claim passes; else trials are too few.
_CHANCE = 0.05


class Verdict(StrEnum):
    """Comparison of our number with the number of the source."""

    REPRODUCED = "reproduced"
    ORDERING = "ordering only"
    UNDECIDED = "undecided"
    MISSED = "missed"
    NOT_JUDGED = "not judged"


@dataclass(frozen=True)
class Quantity:
    """Number of an experiment.

    Attributes:
        name: Name of the measured quantity.
        unit: Unit of ``ours``; empty for a bare number.
        source: Report of the source, in a few words of our own.
        ours: Our measurement; NaN if it could not be made, which counts as missed.
        expected: Region that the source claims, or ``None`` if it claims nothing.
        ordering: Weaker region that only preserves the order that the source reports.
        interval: 95 % interval of ``ours``. Both ends equal ``ours`` if it is computed instead of
            sampled; ``None`` if there is only a single trial.
        chance: Probability that a process that barely violates ``expected`` is called reproduced
            with as many trials; 0 if nothing is sampled.
        likeness: Probability that trials of one process differ at least as much as the source's own
            trials and ours (Fisher's exact test); 1 if the source does not report its trials.
        note: Information that a reader needs to judge the number.
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
    likeness: float = 1.0

    @property
    def verdict(self) -> Verdict:
        """Verdict of the claims on the interval."""
        if self.expected is None:
            return Verdict.NOT_JUDGED
        if math.isnan(self.ours):
            return Verdict.MISSED
        if self.interval is None:
            return Verdict.NOT_JUDGED
        if self.likeness < _DOUBT or self.expected.excludes(self.interval):
            return Verdict.MISSED
        if self.chance <= _CHANCE and self.expected.contains(self.interval):
            return Verdict.REPRODUCED
        if self.ordering is not None and self.ordering.contains(self.interval):
            return Verdict.ORDERING
        return Verdict.UNDECIDED


def computed(
    name: str, unit: str, source: str, ours: float, expected: Claim, *, note: str = ""
) -> Quantity:
    """Return a quantity without spread, which is computed or measured deterministically."""
    interval = None if math.isnan(ours) else (ours, ours)
    return Quantity(name, unit, source, ours, expected, interval=interval, note=note)
