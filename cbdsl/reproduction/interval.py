"""Intervals of 95 % for proportions and means."""

from __future__ import annotations

import math
from collections.abc import Sequence


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
