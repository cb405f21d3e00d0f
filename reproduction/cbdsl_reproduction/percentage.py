"""Percentage of trials as a quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.interval import TAIL, exact_interval
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import ValueRegion


def percentage(claim: Claim, hits: int, trials: int, *, of: str = "", note: str = "") -> Quantity:
    """Return the percentage of trials that are hits, with its exact interval.

    Args:
        claim: Claim about a percentage.
        hits: Number of successes.
        trials: Number of trials; for 0 the quantity is NaN, for 1 it is not judged.
        of: Word for the trials in the note.
        note: Text after the counts in the note.
    """
    counts = f"{hits} of {trials}{of and ' '}{of}"
    noted = f"{counts}; {note}" if note else counts
    return _share(claim, hits, trials, noted, judged=trials > 1)


def same_percentage(claim: Claim, hits: int, trials: int, *, note: str = "") -> Quantity:
    """Return the percentage of trials that are hits, beside that of the source's own trials.

    It is missed if Fisher's exact test denies that both are trials of one process. It is reproduced
    if its interval is within the exact interval of the source's trials.

    Args:
        claim: Claim with the trials of the source.
        hits, trials, note: As for ``percentage``.
    """
    from scipy.stats import fisher_exact

    assert claim.trials is not None, f"'{claim.name}' has no trials of the source"
    own, there = claim.trials
    # The percentage of few trials is no target by itself:
    # 5 of 5 are compatible with a true share of 48 %.
    low, high = _interval(own, there)
    # No share lies beyond 0 or 100 %. A region ends there
    # without a bound, because no process can violate one.
    region = ValueRegion(
        f"{low:.0f} to {high:.0f}, {own} of {there} there",
        low if own else -math.inf,
        high if own < there else math.inf,
    )
    likeness = float(fisher_exact([[hits, trials - hits], [own, there - own]]).pvalue)
    measured = percentage(claim.within(region), hits, trials, note=note)
    return replace(measured, likeness=likeness)


def clustered_percentage(
    claim: Claim, hits: Sequence[int], sizes: Sequence[int], *, of: str = "", note: str = ""
) -> Quantity:
    """Return the percentage of hits for several dependent outcomes in each trial.

    The interval is exact for the effective number of outcomes (Korn and Graubard, 1998). This is
    the number of independent outcomes with the same variance as between these trials. If all or
    none are hits, the variance is zero, and only the number of trials limits the information.

    Args:
        claim: Claim about a percentage.
        hits: Number of hits of each trial.
        sizes: Number of outcomes of each trial; for a single trial the quantity is not judged.
        of: Word for the outcomes in the note.
        note: Text after the counts in the note.
    """
    total, right, trials = sum(sizes), sum(hits), sum(size > 0 for size in sizes)
    noted = f"{right} of {total}{of and ' '}{of} in {len(sizes)} trials{note and '; '}{note}"
    outcomes = effective_number(hits, sizes) if trials > 1 else float(trials)
    known = right / total * outcomes if total else 0.0
    return _share(claim, known, outcomes, noted, judged=trials > 1)


def effective_number(hits: Sequence[int], sizes: Sequence[int]) -> float:
    """Return the effective number of outcomes of at least two trials with outcomes.

    Args:
        hits: Number of hits of each trial.
        sizes: Number of outcomes of each trial.

    Returns:
        Effective number, at most the number of outcomes. It is smaller for fewer trials, whose
        spread is less certain.
    """
    from scipy.special import stdtrit

    # Model: m trials have h_i hits of n_i outcomes each, N outcomes in all. The linearised variance
    # of the share p = sum h_i / N is
    #     v = m / (m - 1) sum (h_i - p n_i)^2 / N^2.
    # Independent outcomes have p (1 - p) / n, which gives their effective number n = p (1 - p) / v.
    # With few trials, v is uncertain. The squared quotient of the t quantiles with N - 1 and m - 1
    # degrees of freedom makes up for it (Korn and Graubard, 1998).
    total, trials = sum(sizes), sum(size > 0 for size in sizes)
    share = sum(hits) / total
    squares = sum((hit - share * size) ** 2 for hit, size in zip(hits, sizes, strict=True))
    variance = trials / (trials - 1) * squares / total**2
    number = share * (1 - share) / variance if variance > 0 else math.inf
    known = float(stdtrit(total - 1, 1 - TAIL) / stdtrit(trials - 1, 1 - TAIL)) ** 2
    return min(number, total) * known


def _share(claim: Claim, hits: float, trials: float, note: str, *, judged: bool) -> Quantity:
    return Quantity(
        claim,
        100 * hits / trials if trials else math.nan,
        _interval(hits, trials) if judged else None,
        chance_of_counts(claim.region, math.ceil(trials)) if claim.region and trials else 0.0,
        note,
    )


def chance_of_counts(region: ValueRegion, trials: int) -> float:
    """Return the probability that trials at an end of a region are called reproduced.

    A coin, or any other process outside of the region, passes at most as often as a process at
    the nearest end.

    Args:
        region: ValueRegion of percentages.
        trials: Number of trials, each a hit or not.
    """
    passing = [hits for hits in range(trials + 1) if region.contains(_interval(hits, trials))]
    if not passing:
        return 0.0
    # The passing numbers of hits are consecutive.
    first, last = passing[0], passing[-1]
    return max((_likelihood(first, last, trials, end / 100) for end in region.ends), default=0.0)


def _interval(hits: float, trials: float) -> tuple[float, float]:
    low, high = exact_interval(hits, trials)
    return 100 * low, 100 * high


def _likelihood(first: int, last: int, trials: int, p: float) -> float:
    """Return the probability that the number of hits is in a closed range."""
    from scipy.special import bdtr

    # Example: a region of 98 ± 5 % ends beyond 100 %.
    p = min(max(p, 0.0), 1.0)
    return float(bdtr(last, trials, p) - (bdtr(first - 1, trials, p) if first else 0.0))
