"""Measured quantity beside the claim of the source, and the verdict that its interval gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.region import Interval, ValueRegion

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
    """Measurement of a quantity about which the source reports.

    Attributes:
        claim: Report of the source.
        ours: Our measurement; NaN if it could not be made, which counts as missed.
        interval: 95 % interval of ``ours``. Both ends equal ``ours`` if it is computed instead of
            sampled; ``None`` if there is only a single trial.
        chance: Probability that a process that barely violates the claim is called reproduced
            with as many trials; 0 if nothing is sampled.
        note: Information that a reader needs to judge the number.
        likeness: Probability that trials of one process differ at least as much as the source's own
            trials and ours (Fisher's exact test); 1 if the source does not report its trials.
    """

    claim: Claim
    ours: float
    interval: Interval | None = None
    chance: float = 0.0
    note: str = ""
    likeness: float = 1.0

    @property
    def name(self) -> str:
        """Name of the measured quantity."""
        return self.claim.name

    @property
    def expected(self) -> ValueRegion | None:
        """ValueRegion of the source's value, or ``None`` if it reports nothing."""
        return self.claim.region

    @property
    def verdict(self) -> Verdict:
        """Verdict of the claim on the interval."""
        region, ordering = self.claim.region, self.claim.ordering
        if region is None:
            return Verdict.NOT_JUDGED
        # A measurement that failed must not vanish from the counts of the pages.
        if math.isnan(self.ours):
            return Verdict.MISSED
        # A single trial has no spread, so that any verdict on it would be luck.
        if self.interval is None:
            return Verdict.NOT_JUDGED
        if self.likeness < _DOUBT or region.excludes(self.interval):
            return Verdict.MISSED
        # With few trials or a narrow region, the interval alone is too
        # weak: a process just outside of the region would often pass.
        if self.chance <= _CHANCE and region.contains(self.interval):
            return Verdict.REPRODUCED
        if ordering is not None and ordering.contains(self.interval):
            return Verdict.ORDERING
        return Verdict.UNDECIDED


def computed(claim: Claim, ours: float, *, note: str = "") -> Quantity:
    """Return a quantity without spread, which is computed or measured deterministically."""
    interval = None if math.isnan(ours) else (ours, ours)
    return Quantity(claim, ours, interval, note=note)
