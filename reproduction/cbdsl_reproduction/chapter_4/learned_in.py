"""Numbers of episodes after which the greedy policies of trials succeed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cbdsl_reproduction.chapter_4.checks import Check
from cbdsl_reproduction.claim import Claim, below
from cbdsl_reproduction.estimate import chance_of_samples, median
from cbdsl_reproduction.interval import median_interval
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.series import Series

# A policy counts as learned once it succeeds this often, at as many checks in a row.
_SUCCESS, _IN_A_ROW = 0.95, 3
_HARDLY_ANY = 15.0  # %, above the interval of 0 in 30 trials


def learned_in(series: Series, checks: Sequence[Check]) -> float:
    """Return the first episode from which the greedy policy succeeds, or infinity.

    It succeeds if 95 % of the episodes are rewarded at three consecutive checks.
    """
    succeeds = [each.success(series) >= _SUCCESS for each in checks]
    for first in range(len(checks) - _IN_A_ROW + 1):
        if all(succeeds[first : first + _IN_A_ROW]):
            return checks[first].episodes
    return math.inf


def learned_in_quantities(
    series: Series, trials: Sequence[Sequence[Check]], source: str, expected: Claim, seed: int
) -> Iterator[Quantity]:
    """Yield the median over all trials, and the share of trials that never learned.

    Args:
        series: Learned series.
        trials: Checks of each trial.
        source: Report of the source.
        expected: Claim about the median.
        seed: Seed of the resampling for the interval.
    """
    episodes = np.array([learned_in(series, checks) for checks in trials])
    finite = episodes[np.isfinite(episodes)]
    middle = float(np.median(episodes))
    has_spread = math.isfinite(middle) and len(episodes) > 1
    yield Quantity(
        f"{series.label}: learned in, median",
        "episodes",
        source,
        middle if math.isfinite(middle) else math.nan,
        expected,
        interval=median_interval(episodes, seed) if has_spread else None,
        chance=chance_of_samples(expected, episodes, median, seed),
        note=f"{finite.min():g} to {finite.max():g}" if len(finite) else "",
    )
    never = len(episodes) - len(finite)
    name = f"{series.label}: trials that never learned"
    yield percentage(name, "none", never, len(episodes), below(_HARDLY_ANY))
