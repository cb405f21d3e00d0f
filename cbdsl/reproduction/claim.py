"""A claim: the region in which the source's words put the true value of a quantity."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

Interval = tuple[float, float]


@dataclass(frozen=True)
class Claim:
    """A region of values, which a 95 % interval lies in, lies out of, or does neither.

    Its negation is the rest of the line, so that no measurement clears a claim and its negation.

    Attributes:
        text: the region for readers, such as ``> 0.8``.
        low, high: its ends; infinite where it has none.
        open: whether the ends themselves are left out.
        hindsight: whether it was set when the numbers were known.
    """

    text: str
    low: float = -math.inf
    high: float = math.inf
    open: bool = False
    hindsight: bool = False

    def contains(self, interval: Interval) -> bool:
        """Whether all of an interval is in the region."""
        first, last = interval
        if self.open:
            return self.low < first and last < self.high
        slack = 1e-9 * max(1.0, *(abs(end) for end in self.ends))
        return self.low - slack <= first and last <= self.high + slack

    def excludes(self, interval: Interval) -> bool:
        """Whether none of an interval is in the region."""
        first, last = interval
        if self.open:
            return last <= self.low or self.high <= first
        return last < self.low or self.high < first

    @property
    def ends(self) -> tuple[float, ...]:
        """The finite ends of the region, where the claim is only just false."""
        return tuple(end for end in (self.low, self.high) if math.isfinite(end))


def above(bound: float) -> Claim:
    """The value is larger than ``bound``."""
    return Claim(f"> {bound:.3g}", low=bound, open=True)


def below(bound: float) -> Claim:
    """The value is smaller than ``bound``."""
    return Claim(f"< {bound:.3g}", high=bound, open=True)


def at_least(bound: float) -> Claim:
    """The value is ``bound`` or more."""
    return Claim(f">= {bound:g}", low=bound)


def at_most(bound: float) -> Claim:
    """The value is ``bound`` or less."""
    return Claim(f"<= {bound:g}", high=bound)


def near(target: float, tolerance: float) -> Claim:
    """The value is within ``tolerance`` of ``target``."""
    return between(target - tolerance, target + tolerance, f"{target:g} ± {tolerance:.3g}")


def between(low: float, high: float, text: str = "") -> Claim:
    """The value is in a closed range."""
    return Claim(text or f"{low:g} to {high:g}", low, high)


def in_hindsight(claim: Claim) -> Claim:
    """The same claim, marked as set when the numbers were known."""
    return replace(claim, text=f"{claim.text} (set in hindsight)", hindsight=True)
