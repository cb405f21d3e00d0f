"""ValueRegion: values among which the source puts a quantity."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

Interval = tuple[float, float]


@dataclass(frozen=True)
class ValueRegion:
    """ValueRegion of values that contains a 95 % interval, excludes it, or does neither.

    Its negation is the complement, so that no measurement can satisfy a region and its negation.

    Attributes:
        text: ValueRegion for readers, such as ``> 0.8``.
        low, high: Ends of the region; infinite if it is unbounded.
        open: True if the ends themselves are excluded.
        hindsight: True if it was set with known numbers.
    """

    text: str
    low: float = -math.inf
    high: float = math.inf
    open: bool = False
    hindsight: bool = False

    def contains(self, interval: Interval) -> bool:
        """Return whether the region contains a whole interval."""
        first, last = interval
        if self.open:
            # A strict claim such as "more" is not met at its bound: a difference of 0 is no gain.
            return self.low < first and last < self.high
        # Rounding errors must not exclude an interval that ends at a closed bound, for example at
        # 100 %.
        slack = 1e-9 * max(1.0, *(abs(end) for end in self.ends))
        return self.low - slack <= first and last <= self.high + slack

    def excludes(self, interval: Interval) -> bool:
        """Return whether the region and an interval are disjoint."""
        first, last = interval
        # An interval that overlaps the region only in part is
        # neither contained nor excluded, and decides nothing.
        if self.open:
            return last <= self.low or self.high <= first
        return last < self.low or self.high < first

    @property
    def ends(self) -> tuple[float, ...]:
        """Finite ends of the region, next to which a value is barely outside."""
        return tuple(end for end in (self.low, self.high) if math.isfinite(end))


def above(bound: float) -> ValueRegion:
    """Return the region of values larger than ``bound``."""
    return ValueRegion(f"> {bound:.3g}", low=bound, open=True)


def below(bound: float) -> ValueRegion:
    """Return the region of values smaller than ``bound``."""
    return ValueRegion(f"< {bound:.3g}", high=bound, open=True)


def at_least(bound: float) -> ValueRegion:
    """Return the region of ``bound`` and larger values."""
    return ValueRegion(f">= {bound:g}", low=bound)


def at_most(bound: float) -> ValueRegion:
    """Return the region of ``bound`` and smaller values."""
    return ValueRegion(f"<= {bound:g}", high=bound)


def near(target: float, tolerance: float) -> ValueRegion:
    """Return the region of values within ``tolerance`` of ``target``."""
    return between(target - tolerance, target + tolerance, f"{target:g} ± {tolerance:.3g}")


def between(low: float, high: float, text: str = "") -> ValueRegion:
    """Return a closed range of values."""
    return ValueRegion(text or f"{low:g} to {high:g}", low, high)


def in_hindsight(region: ValueRegion) -> ValueRegion:
    """Return the same region, marked as set with known numbers."""
    return replace(region, text=f"{region.text} (set in hindsight)", hindsight=True)
