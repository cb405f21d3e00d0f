"""Statistic of samples as a quantity, with its bootstrap interval and chance of passing."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbdsl_reproduction.claim import Claim, Interval
from cbdsl_reproduction.interval import interval_of
from cbdsl_reproduction.quantity import Quantity

Floats = NDArray[np.float64]
Statistic = Callable[[Floats], Floats]
"""Statistic along the first axis, such as ``numpy.mean`` with ``axis=0``."""

# Number of data sets for the estimate of a chance, and draws of the interval of each.
_SETS, _DRAWS = 1000, 200


def estimate(
    name: str,
    unit: str,
    source: str,
    samples: Floats,
    statistic: Statistic,
    interval: Callable[[Floats], Interval],
    expected: Claim | None,
    *,
    ordering: Claim | None = None,
    seed: int = 0,
    note: str = "",
) -> Quantity:
    """Return a statistic of samples as a quantity.

    Args:
        name, unit, source, expected, ordering, note: Fields of ``Quantity``.
        samples: Samples, shape (n,); for n = 0 the quantity is NaN, for n = 1 it is not judged.
        statistic: Statistic of the samples.
        interval: Function that returns the statistic's 95 % interval.
        seed: Seed of the resampling for the estimate of the chance.
    """
    values = np.asarray(samples, dtype=float)
    return Quantity(
        name,
        unit,
        source,
        float(statistic(values)) if len(values) else math.nan,
        expected,
        ordering,
        interval(values) if len(values) > 1 else None,
        0.0 if expected is None else chance_of_samples(expected, values, statistic, seed),
        note,
    )


def mean_of(
    name: str,
    unit: str,
    source: str,
    samples: Sequence[float],
    expected: Claim | None,
    *,
    ordering: Claim | None = None,
    seed: int = 0,
    note: str = "",
) -> Quantity:
    """Return the mean of samples as a quantity; see ``estimate``."""
    return estimate(
        name,
        unit,
        source,
        np.array(samples, dtype=float),
        mean,
        interval_of(mean, seed),
        expected,
        ordering=ordering,
        seed=seed,
        note=note,
    )


def mean(values: Floats) -> Floats:
    """Return the mean along the first axis."""
    result: Floats = values.mean(axis=0)
    return result


def median(values: Floats) -> Floats:
    """Return the median along the first axis."""
    result: Floats = np.median(values, axis=0)
    return result


def chance_of_samples(claim: Claim, samples: Floats, statistic: Statistic, seed: int = 0) -> float:
    """Return the probability that samples at an end of the claim's region are called reproduced.

    As many samples as measured are drawn from the measured ones, which are shifted so that their
    statistic is at the end of the region.

    Args:
        claim: Claim about the statistic.
        samples: Samples, shape (n,); for n < 2 there is no interval, and the result is 0.
        statistic: Statistic of samples along the first axis.
        seed: Seed of the draws.
    """
    # Double bootstrap: ``_SETS`` data sets are drawn from the samples, and the percentile interval
    # of each from ``_DRAWS`` resamplings. The chance is the share of the intervals within the
    # claim's region, after a shift of the statistic to just outside of that region. Assumptions:
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
    shifts = [_outside(claim, end) - centre for end in claim.ends]
    return max((_share(claim, intervals, shift) for shift in shifts), default=0.0)


def _outside(claim: Claim, end: float) -> float:
    """Return the value next to an end of a region that violates the claim."""
    step = 1e-6 * max(1.0, abs(end))
    return end - step if end == claim.low else end + step


def _share(claim: Claim, intervals: list[Interval], shift: float) -> float:
    """Return the share of shifted intervals that the claim contains."""
    return sum(claim.contains((low + shift, high + shift)) for low, high in intervals) / len(
        intervals
    )
