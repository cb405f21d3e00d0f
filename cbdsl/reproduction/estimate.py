"""A statistic of samples as a quantity, with its bootstrap interval and chance of passing."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbdsl.reproduction.claim import Claim, Interval
from cbdsl.reproduction.interval import interval_of
from cbdsl.reproduction.quantity import Quantity

Floats = NDArray[np.float64]
Statistic = Callable[[Floats], Floats]
"""A statistic along the first axis, such as ``numpy.mean`` with ``axis=0``."""

# Data sets that a chance is estimated from, and draws of the interval of each.
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
    """A statistic of samples.

    Args:
        name, unit, source, expected, ordering, note: see ``Quantity``.
        samples: shape (n,); of none the quantity is NaN, of a single one it is not judged.
        statistic: of the samples.
        interval: the statistic's 95 % interval.
        seed: of the resampling by which the chance is estimated.
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
    """The mean of samples, see ``estimate``."""
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
    """The mean along the first axis."""
    result: Floats = values.mean(axis=0)
    return result


def median(values: Floats) -> Floats:
    """The median along the first axis."""
    result: Floats = np.median(values, axis=0)
    return result


def chance_of_samples(claim: Claim, samples: Floats, statistic: Statistic, seed: int = 0) -> float:
    """How likely samples whose statistic is at an end of the claim's region are called reproduced.

    As many samples as there are, drawn from the measured ones, which are moved so that their
    statistic is at the end.

    Args:
        claim: about the statistic.
        samples: shape (n,); of less than two there is no interval, and none passes.
        statistic: of samples along the first axis.
        seed: of the draws.
    """
    n, centre = len(samples), float(statistic(samples)) if len(samples) else math.nan
    if n < 2 or not math.isfinite(centre):
        return 0.0
    rng = np.random.default_rng(seed)
    sets = samples[rng.integers(n, size=(n, _SETS))]
    again = sets[rng.integers(n, size=(n, _DRAWS)), :]
    # Between infinite values, as of trials that never learned, nothing is to interpolate.
    method: Literal["linear", "nearest"] = "linear" if np.isfinite(samples).all() else "nearest"
    lows, highs = np.percentile(statistic(again), (2.5, 97.5), axis=0, method=method)
    intervals = [(float(low), float(high)) for low, high in zip(lows, highs, strict=True)]
    shifts = [_outside(claim, end) - centre for end in claim.ends]
    return max((_share(claim, intervals, shift) for shift in shifts), default=0.0)


def _outside(claim: Claim, end: float) -> float:
    """The next value to an end of a region for which the claim is false."""
    step = 1e-6 * max(1.0, abs(end))
    return end - step if end == claim.low else end + step


def _share(claim: Claim, intervals: list[Interval], shift: float) -> float:
    """Share of intervals that the claim contains once they are moved."""
    return sum(claim.contains((low + shift, high + shift)) for low, high in intervals) / len(
        intervals
    )
