"""Claim: report of the source about one quantity, and the rule of its verdict."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from cbdsl_reproduction.region import ValueRegion


class VerdictRule(StrEnum):
    """Rule by which a measurement gets its verdict."""

    REGION = "the 95 % interval is in the region"
    BOUND = "the 95 % interval is in a region that the same trials bound"
    TRIALS = "the source's trials and ours are of one process"
    NONE = "no verdict"


@dataclass(frozen=True)
class Claim:
    """Report of the source about one quantity.

    Texts in braces, such as ``{law}``, stand for parts that a measurement names.

    Attributes:
        place: Section, figure or table of the source.
        name: Name of the quantity.
        unit: Unit of the quantity; empty for a bare number.
        report: Report of the source, in a few words of our own.
        region: Region of the reported value; ``None`` if nothing is reported, or until it is
            measured.
        ordering: Weaker region that only preserves the reported order.
        bound: Function that returns the region from a bound of the same trials.
        trials: Number of hits of the source, and of its trials.
    """

    place: str
    name: str
    unit: str = ""
    report: str = ""
    region: ValueRegion | None = None
    ordering: ValueRegion | None = None
    bound: Callable[[float], ValueRegion] | None = None
    trials: tuple[int, int] | None = None

    @property
    def rule(self) -> VerdictRule:
        """Rule of its verdict."""
        # A source that reports its counts has an interval of its own.
        # A fixed region around its percentage would ignore that.
        if self.trials is not None:
            return VerdictRule.TRIALS
        if self.bound is not None:
            return VerdictRule.BOUND
        return VerdictRule.NONE if self.region is None else VerdictRule.REGION

    def named(self, **parts: str) -> Claim:
        """Return the claim with texts in place of the words in braces."""
        name, report = self.name, self.report
        for key, text in parts.items():
            name, report = (words.replace(f"{{{key}}}", text) for words in (name, report))
        return replace(self, name=name, report=report)

    def within(self, region: ValueRegion) -> Claim:
        """Return the claim with its measured region."""
        return replace(self, region=region)

    def at(self, value: float) -> Claim:
        """Return the claim with a region from a measured bound."""
        assert self.bound is not None, f"the region of '{self.name}' has no measured bound"
        return self.within(self.bound(value))

    def describes(self, name: str) -> bool:
        """Return whether it is the claim about a measured quantity of a name."""
        # Each word in braces stands for at least one
        # character, so that an empty name matches no claim.
        parts = re.split(r"\{\w+\}", self.name)
        return re.fullmatch(".+".join(map(re.escape, parts)), name) is not None


Claims = Mapping[str, Sequence[Claim]]
"""Claims by experiment."""
