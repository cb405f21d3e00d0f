"""Means of many trials that a few odd ones do not sway, and how sure they are.

Agarwal et al., "Deep Reinforcement Learning at the Edge of the Statistical Precipice" (2021), say
why: with few trials, means follow outliers and medians jump.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cbdsl.extend.backend import Floats

_DRAWS = 2000
_PART = 100
_LEVEL = 0.95


class Band(NamedTuple):
    """Curve over trials.

    Attributes:
        middle: Means, shape (n,).
        lower, upper: Bounds of their 95 % bootstrap intervals, shape (n,).
    """

    middle: Floats
    lower: Floats
    upper: Floats


Center = Callable[[Floats], Floats]


# Model of the interquartile mean: of n sorted trials, trial i covers the share [(i - 1) / n, i /
# n]. Its weight is the part of this span within [1/4, 3/4], times 2, so that all weights add up to
# 1. Six trials have the weights 0, 1/6, 1/3, 1/3, 1/6 and 0. Each episode is sorted by itself: the
# middle trials of one episode may be others in the next.
def interquartile_mean(values: Floats) -> Floats:
    """Return the mean of the middle half of the trials; shape (..., trials, n) to (..., n).

    If a quarter of the trials is no whole number, the trials at the edges count in part.
    """
    count = values.shape[-2]
    edges = np.clip(np.arange(count + 1) / count, 0.25, 0.75)
    weights = 2 * np.diff(edges)
    mean: Floats = np.einsum("t,...tn->...n", weights, np.sort(values, axis=-2))
    return mean


def mean(values: Floats) -> Floats:
    """Return the mean of the trials; shape (..., trials, n) to (..., n)."""
    means: Floats = values.mean(axis=-2)
    return means


def band(values: Floats, center: Center = interquartile_mean, seed: int = 0) -> Band:
    """Return the middle of each column, with its percentile bootstrap interval.

    Whole trials are resampled, because their episodes depend on each other.

    Args:
        values: Values, shape (trials, n).
        center: Function that computes the mean over trials.
        seed: Seed of the resampling.
    """
    rng, count = np.random.default_rng(seed), len(values)
    # A single trial can only be drawn as itself, so that its interval is the curve.
    draws = _DRAWS if count > 1 else 1
    # In parts, because all draws of a hundred long trials together would take gigabytes.
    parts = [
        center(values[rng.integers(count, size=(min(_PART, draws - done), count))])
        for done in range(0, draws, _PART)
    ]
    # The percentile bootstrap assumes independent trials. With fewer than about ten, it is too
    # narrow.
    tail = (1 - _LEVEL) / 2
    lower, upper = np.quantile(np.concatenate(parts), (tail, 1 - tail), axis=0)
    return Band(center(values), lower, upper)


def running_mean(values: Floats, window: int) -> Floats:
    """Return the mean of up to ``window`` last values, at each place along the last axis."""
    count = values.shape[-1]
    # Differences of cumulative sums cost the same for each window. The first windows are shorter.
    sums = np.concatenate([np.zeros((*values.shape[:-1], 1)), values.cumsum(axis=-1)], axis=-1)
    ends = np.arange(1, count + 1)
    begins = np.maximum(ends - window, 0)
    mean: Floats = (sums[..., ends] - sums[..., begins]) / (ends - begins)
    return mean
