"""Intervals of 95 % for means and medians, and means that are robust to outliers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal, TypeVar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Sample = TypeVar("Sample")

#: Probability on either side of an interval.
TAIL = 0.025


def exact_interval(hits: float, trials: float) -> tuple[float, float]:
    """Return the Clopper-Pearson interval of a proportion.

    Args:
        hits: Number of successes; between integers, the bounds are interpolated by the beta law.
        trials: Number of trials, above 0; an effective number need not be an integer.

    Raises:
        ValueError: If there were no trials, or fewer than hits.
    """
    # ``binomtest`` solves for the same bounds numerically, and takes integers only.
    from scipy.stats import beta

    if not (0 <= hits <= trials and trials > 0):
        raise ValueError(f"{hits} of {trials} is not a proportion")
    # The bounds are conservative: they contain the true share
    # in at least 95 % of all samples, even if trials are few.
    lower = 0.0 if hits == 0 else float(beta.ppf(TAIL, hits, trials - hits + 1))
    upper = 1.0 if hits == trials else float(beta.ppf(1 - TAIL, hits + 1, trials - hits))
    return lower, upper


def bootstrap_interval(samples: Sequence[float], seed: int = 0) -> tuple[float, float]:
    """Return the bootstrap interval of the mean; ``seed`` controls the resampling.

    Raises:
        ValueError: There are no samples.
    """
    import numpy as np

    # A mean is cheap to compute, so that many draws can steady the ends of its interval.
    low, high = _bootstrap(np.asarray(samples, dtype=float), np.mean, seed, 10_000)
    return float(low), float(high)


def resampled_interval(
    samples: Sequence[Sample],
    statistic: Callable[[Sequence[Sample]], float],
    seed: int = 0,
    draws: int = 1000,
) -> tuple[float, float]:
    """Return the bootstrap interval of a statistic of samples of any kind, such as curves.

    Raises:
        ValueError: There are no samples.
    """
    import numpy as np

    if not samples:
        raise ValueError("no samples")
    # Samples are drawn as a whole, for example the curve of a
    # trial: the episodes within one curve depend on each other.
    chosen = np.random.default_rng(seed).integers(len(samples), size=(draws, len(samples)))
    drawn = [statistic([samples[place] for place in each]) for each in chosen]
    low, high = np.percentile(drawn, (2.5, 97.5))
    return float(low), float(high)


def interquartile_mean(values: Floats) -> Floats:
    """Return the mean of the middle half along the first axis, of at least one value.

    A quarter of the values, rounded down, is excluded at either end.
    """
    import numpy as np

    # Trials of learning have outliers at both ends. This mean ignores
    # them, and has less variance than the median (Agarwal et al., 2021).
    out = len(values) // 4
    middle: Floats = np.sort(values, axis=0)[out : len(values) - out].mean(axis=0)
    return middle


def interquartile_interval(values: Floats, seed: int = 0) -> tuple[Floats, Floats]:
    """Return the bootstrap interval of the interquartile mean along the first axis.

    Args:
        values: Values of n independent trials, shape (n, ...).
        seed: Seed of the resampling.

    Returns:
        Lower and upper ends, shape (...).

    Raises:
        ValueError: There are no values.
    """
    return _bootstrap(values, interquartile_mean, seed)


def interval_of(
    statistic: Callable[[Floats], Floats], seed: int = 0
) -> Callable[[Floats], tuple[float, float]]:
    """Return a function of samples (n,) for the bootstrap interval of a statistic."""

    def interval(values: Floats) -> tuple[float, float]:
        low, high = _bootstrap(values, statistic, seed)
        return float(low), float(high)

    return interval


def median_interval(values: Floats, seed: int = 0) -> tuple[float, float]:
    """Return the bootstrap interval of the median of values (n,), some of which may be infinite."""
    import numpy as np

    # Infinite values cannot be interpolated.
    low, high = _bootstrap(values, np.median, seed, method="nearest")
    return float(low), float(high)


def _bootstrap(
    values: Floats,
    statistic: Callable[[Floats], Floats],
    seed: int,
    draws: int = 2000,
    method: Literal["linear", "nearest"] = "linear",
) -> tuple[Floats, Floats]:
    """Return the percentile bootstrap interval of a statistic along the first axis."""
    import numpy as np

    if not len(values):
        raise ValueError("no samples")
    # The samples have to be independent. With few of them, percentile intervals are too narrow.
    chosen = np.random.default_rng(seed).integers(len(values), size=(draws, len(values)))
    drawn = [statistic(values[each]) for each in chosen]
    low, high = np.percentile(drawn, (2.5, 97.5), axis=0, method=method)
    return low, high
