"""Statistic of samples as a quantity, with its bootstrap interval and chance of passing."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.interval import interval_of
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import Interval, ValueRegion

Floats = NDArray[np.float64]
Statistic = Callable[[Floats], Floats]
"""Statistic along the first axis, such as ``numpy.mean`` with ``axis=0``."""

# Number of data sets for the estimate of a chance, and draws of the interval of each.
# With 1000 data sets, a chance of 5 % has a standard error of 0.7 %.
_SETS, _DRAWS = 1000, 200


def estimate(
    claim: Claim,
    samples: Floats,
    statistic: Statistic,
    interval: Callable[[Floats], Interval],
    *,
    seed: int = 0,
    note: str = "",
) -> Quantity:
    """Return a statistic of samples as a quantity.

    Args:
        claim: Claim about the statistic.
        samples: Samples, shape (n,); for n = 0 the quantity is NaN, for n = 1 it is not judged.
        statistic: Statistic of the samples.
        interval: Function that returns the statistic's 95 % interval.
        seed: Seed of the resampling for the estimate of the chance.
        note: Note of the quantity.
    """
    values = np.asarray(samples, dtype=float)
    return Quantity(
        claim,
        float(statistic(values)) if len(values) else math.nan,
        interval(values) if len(values) > 1 else None,
        chance_of_samples(claim.region, values, statistic, seed) if claim.region else 0.0,
        note,
    )


def mean_of(claim: Claim, samples: Sequence[float], *, seed: int = 0, note: str = "") -> Quantity:
    """Return the mean of samples as a quantity; see ``estimate``."""
    values = np.array(samples, dtype=float)
    return estimate(claim, values, mean, interval_of(mean, seed), seed=seed, note=note)


def mean(values: Floats) -> Floats:
    """Return the mean along the first axis."""
    result: Floats = values.mean(axis=0)
    return result


def median(values: Floats) -> Floats:
    """Return the median along the first axis."""
    result: Floats = np.median(values, axis=0)
    return result


def chance_of_samples(
    region: ValueRegion, samples: Floats, statistic: Statistic, seed: int = 0
) -> float:
    """Return the probability that samples at an end of a region are called reproduced.

    As many samples as measured are drawn from the measured ones, which are shifted so that their
    statistic is at the end of the region.

    Args:
        region: ValueRegion of the statistic.
        samples: Samples, shape (n,); for n < 2 there is no interval, and the result is 0.
        statistic: Statistic of samples along the first axis.
        seed: Seed of the draws.
    """
    # Double bootstrap: ``_SETS`` data sets are drawn from the samples, and the percentile interval
    # of each from ``_DRAWS`` resamplings. The chance is the share of the intervals within the
    # region, after a shift of the statistic to just outside of that region. Assumptions:
    # the spread at the end of the region is the measured one, and a shift of the samples shifts the
    # statistic by as much. Means and medians have this property; ratios have not.
    n, centre = len(samples), float(statistic(samples)) if len(samples) else math.nan
    if n < 2 or not math.isfinite(centre):
        return 0.0
    rng = np.random.default_rng(seed)
    sets = samples[rng.integers(n, size=(n, _SETS))]
    # All data sets share their resampling, shape (n, draws, sets): independent indices would need
    # an array of that size as well.
    again = sets[rng.integers(n, size=(n, _DRAWS)), :]
    # Infinite values, as of trials that never learned, cannot be interpolated.
    method: Literal["linear", "nearest"] = "linear" if np.isfinite(samples).all() else "nearest"
    lows, highs = np.percentile(statistic(again), (2.5, 97.5), axis=0, method=method)
    intervals = [(float(low), float(high)) for low, high in zip(lows, highs, strict=True)]
    shifts = [_outside(region, end) - centre for end in region.ends]
    return max((_share(region, intervals, shift) for shift in shifts), default=0.0)


def _outside(region: ValueRegion, end: float) -> float:
    """Return the value next to an end of a region, outside of it."""
    # The smallest violation passes most easily, so that its chance bounds that of all others.
    step = 1e-6 * max(1.0, abs(end))
    return end - step if end == region.low else end + step


def _share(region: ValueRegion, intervals: list[Interval], shift: float) -> float:
    """Return the share of shifted intervals that a region contains."""
    return sum(region.contains((low + shift, high + shift)) for low, high in intervals) / len(
        intervals
    )
