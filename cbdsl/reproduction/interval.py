"""Intervals of 95 % for proportions and means, and means that outliers do not move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def exact_interval(hits: int, trials: int, level: float = 0.95) -> tuple[float, float]:
    """Clopper-Pearson interval of a proportion.

    Args:
        hits: successes.
        trials: how many there were, at least one.
        level: probability with which such intervals include the true proportion, at least.

    Raises:
        ValueError: there were no trials, or not as many as hits.
    """
    if not (0 <= hits <= trials and trials > 0):
        raise ValueError(f"{hits} of {trials} is no proportion")
    tail = (1 - level) / 2

    def at_least(k: int, p: float) -> float:
        return sum(
            math.comb(trials, i) * p**i * (1 - p) ** (trials - i) for i in range(k, trials + 1)
        )

    def root(wanted: float, k: int) -> float:
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if at_least(k, middle) < wanted else (low, middle)
        return low

    lower = 0.0 if hits == 0 else root(tail, hits)
    upper = 1.0 if hits == trials else root(1 - tail, hits + 1)
    return lower, upper


def bootstrap_interval(
    samples: Sequence[float], seed: int = 0, level: float = 0.95, draws: int = 10_000
) -> tuple[float, float]:
    """Percentile bootstrap interval of a mean.

    Args:
        samples: at least one; the interval of a single one is a point.
        seed: of the resampling.
        level: probability that the interval holds.
        draws: resampled means.

    Raises:
        ValueError: there are no samples.
    """
    import numpy as np

    if not len(samples):
        raise ValueError("no samples")
    values = np.asarray(samples, dtype=float)
    chosen = np.random.default_rng(seed).integers(len(values), size=(draws, len(values)))
    tail = 50 * (1 - level)
    low, high = np.percentile(values[chosen].mean(axis=1), (tail, 100 - tail))
    return float(low), float(high)


def interquartile_mean(values: Floats) -> Floats:
    """Mean of the middle half along the first axis, of at least one value.

    A quarter is left out at either end, rounded down.
    """
    import numpy as np

    out = len(values) // 4
    middle: Floats = np.sort(values, axis=0)[out : len(values) - out].mean(axis=0)
    return middle


def interquartile_interval(
    values: Floats, seed: int = 0, level: float = 0.95, draws: int = 2000
) -> tuple[Floats, Floats]:
    """Percentile bootstrap interval of the interquartile mean along the first axis.

    Args:
        values: shape (n, ...), of n independent trials.
        seed: of the resampling.
        level: probability that the interval holds.
        draws: resampled means.

    Returns:
        Lower and upper ends, shape (...).

    Raises:
        ValueError: there are no values.
    """
    import numpy as np

    if not len(values):
        raise ValueError("no samples")
    rng = np.random.default_rng(seed)
    means = [
        interquartile_mean(values[rng.integers(len(values), size=len(values))])
        for _ in range(draws)
    ]
    tail = 50 * (1 - level)
    low, high = np.percentile(means, (tail, 100 - tail), axis=0)
    return low, high


def over_trials(values: Floats, seed: int = 0) -> tuple[float, float] | None:
    """``interquartile_interval`` of one number a trial; ``None`` where there is but one trial.

    Args:
        values: shape (n,).
        seed: of the resampling.
    """
    if len(values) == 1:
        return None
    low, high = interquartile_interval(values, seed)
    return float(low), float(high)


def median_interval(
    values: Floats, seed: int = 0, level: float = 0.95, draws: int = 2000
) -> tuple[float, float]:
    """Percentile bootstrap interval of the median of values of which some may be infinite.

    Args:
        values: shape (n,), at least one.
        seed: of the resampling.
        level: probability that the interval holds.
        draws: resampled medians.
    """
    import numpy as np

    chosen = np.random.default_rng(seed).integers(len(values), size=(draws, len(values)))
    tail = 50 * (1 - level)
    medians = np.median(values[chosen], axis=1)
    # Between infinite ones there is nothing to interpolate.
    low, high = np.percentile(medians, (tail, 100 - tail), method="nearest")
    return float(low), float(high)
