"""A measured quantity beside what the source reports, and a verdict that a rule gives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

Interval = tuple[float, float]


class Verdict(StrEnum):
    """How our number stands beside the source's."""

    REPRODUCED = "reproduced"
    ORDERING = "ordering only"
    MISSED = "missed"


@dataclass(frozen=True)
class Claim:
    """The rule that decides whether a measurement agrees with the source.

    Attributes:
        text: the rule for readers, such as ``> 0.8``.
        holds: decides by the number and its 95 % interval; never called with NaN.
    """

    text: str
    holds: Callable[[float, Interval | None], bool]


def above(bound: float) -> Claim:
    """The number is larger than ``bound``."""
    return Claim(f"> {bound:g}", lambda ours, _: ours > bound)


def below(bound: float) -> Claim:
    """The number is smaller than ``bound``."""
    return Claim(f"< {bound:g}", lambda ours, _: ours < bound)


def at_least(bound: float) -> Claim:
    """The number is ``bound`` or more."""
    return Claim(f">= {bound:g}", lambda ours, _: ours >= bound)


def at_most(bound: float) -> Claim:
    """The number is ``bound`` or less."""
    return Claim(f"<= {bound:g}", lambda ours, _: ours <= bound)


def near(target: float, tolerance: float) -> Claim:
    """The number is within ``tolerance`` of ``target``."""
    return Claim(
        f"{target:g} ± {tolerance:g}", lambda ours, _: abs(ours - target) <= tolerance * (1 + 1e-9)
    )


def clearly_below(bound: float) -> Claim:
    """The number and all of its 95 % interval are smaller than ``bound``."""
    return Claim(
        f"interval below {bound:g}",
        lambda ours, interval: ours < bound and interval is not None and interval[1] < bound,
    )


def clearly_above(bound: float) -> Claim:
    """The number and all of its 95 % interval are larger than ``bound``."""
    return Claim(
        f"interval above {bound:.3g}",
        lambda ours, interval: ours > bound and interval is not None and interval[0] > bound,
    )


def covering(target: float) -> Claim:
    """The 95 % interval of the number includes ``target``."""
    return Claim(
        f"interval includes {target:g}",
        lambda ours, interval: interval is not None and interval[0] <= target <= interval[1],
    )


@dataclass(frozen=True)
class Quantity:
    """One number of an experiment.

    Attributes:
        name: what was measured.
        unit: of ``ours``; empty for a bare number.
        source: what the source reports, in a few words of our own.
        ours: what we measured; NaN where it could not be, which is a miss.
        expected: when the number counts as reproduced.
        ordering: when at least the order that the source reports holds, where that says less.
        interval: 95 % interval of ``ours``, or ``None`` where it has no spread.
        note: what a reader must know to judge it.
    """

    name: str
    unit: str
    source: str
    ours: float
    expected: Claim
    ordering: Claim | None = None
    interval: Interval | None = None
    note: str = ""

    @property
    def verdict(self) -> Verdict:
        """The verdict of the rules on the number."""
        if math.isnan(self.ours):
            return Verdict.MISSED
        if self.expected.holds(self.ours, self.interval):
            return Verdict.REPRODUCED
        if self.ordering is not None and self.ordering.holds(self.ours, self.interval):
            return Verdict.ORDERING
        return Verdict.MISSED
