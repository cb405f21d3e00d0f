"""Numbers of episodes after which the greedy policies of trials succeed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl_reproduction.chapter_4.checks import Check
from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.estimate import chance_of_samples, median
from cbdsl_reproduction.interval import median_interval
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import ValueRegion, below
from cbdsl_reproduction.series import Series

# A policy counts as learned once it succeeds this often, at as many checks in a row.
_SUCCESS, _IN_A_ROW = 0.95, 3
_HARDLY_ANY = 15.0  # %, above the interval of 0 in 30 trials


class LearnedInClaims(NamedTuple):
    """Claims about the episodes of learning: their median, and the trials that never learned."""

    median: Claim
    never: Claim


def learned_in_claims(
    place: str, series: Series, report: str, region: ValueRegion
) -> LearnedInClaims:
    """Return the claims about a series.

    Args:
        place: Section or figure of the source.
        series: Learned series.
        report: Report of the source about the median.
        region: ValueRegion of the median.
    """
    label = series.label
    return LearnedInClaims(
        Claim(place, f"{label}: learned in, median", "episodes", report, region),
        Claim(place, f"{label}: trials that never learned", "%", "none", below(_HARDLY_ANY)),
    )


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
    series: Series, trials: Sequence[Sequence[Check]], claims: LearnedInClaims, seed: int
) -> Iterator[Quantity]:
    """Yield the median over all trials, and the share of trials that never learned.

    Args:
        series: Learned series.
        trials: Checks of each trial.
        claims: Claims about the series.
        seed: Seed of the resampling for the interval.
    """
    episodes = np.array([learned_in(series, checks) for checks in trials])
    finite = episodes[np.isfinite(episodes)]
    middle = float(np.median(episodes))
    has_spread = math.isfinite(middle) and len(episodes) > 1
    assert claims.median.region is not None
    yield Quantity(
        claims.median,
        middle if math.isfinite(middle) else math.nan,
        interval=median_interval(episodes, seed) if has_spread else None,
        chance=chance_of_samples(claims.median.region, episodes, median, seed),
        note=f"{finite.min():g} to {finite.max():g}" if len(finite) else "",
    )
    never = len(episodes) - len(finite)
    yield percentage(claims.never, never, len(episodes))
