"""A percentage of trials as a quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cbdsl.numeric.proportion import exact_interval
from cbdsl.reproduction.claim import Claim
from cbdsl.reproduction.quantity import Quantity


def percentage(
    name: str,
    source: str,
    hits: int,
    trials: int,
    expected: Claim | None,
    *,
    ordering: Claim | None = None,
    of: str = "",
    note: str = "",
) -> Quantity:
    """The percentage of trials that are hits, with its exact interval.

    Args:
        name, source, expected, ordering: see ``Quantity``; claims are about percentages.
        hits: successes.
        trials: all trials; of none the quantity is NaN, of a single one it is not judged.
        of: a word for the trials in the note.
        note: follows the counts in the note.
    """
    counts = f"{hits} of {trials}{of and ' '}{of}"
    noted = f"{counts}; {note}" if note else counts
    return _share(name, source, hits, trials, expected, ordering, noted)


def clustered_percentage(
    name: str,
    source: str,
    shares: Sequence[float],
    expected: Claim,
    *,
    ordering: Claim | None = None,
    note: str = "",
) -> Quantity:
    """The percentage of hits that come several to a trial, and depend on each other there.

    A trial counts once: the interval is the exact one of as many trials, which is that of the hits
    where all of a trial go together, and wider than theirs where they do not.

    Args:
        name, source, expected, ordering, note: see ``Quantity``; claims are about percentages.
        shares: of hits, one for each trial.
    """
    hits = min(sum(shares), len(shares))
    return _share(name, source, hits, len(shares), expected, ordering, note)


def _share(
    name: str,
    source: str,
    hits: float,
    trials: int,
    expected: Claim | None,
    ordering: Claim | None,
    note: str,
) -> Quantity:
    return Quantity(
        name,
        "%",
        source,
        100 * hits / trials if trials else math.nan,
        expected,
        ordering,
        _interval(hits, trials) if trials > 1 else None,
        chance_of_counts(expected, trials) if expected is not None and trials else 0.0,
        note,
    )


def chance_of_counts(claim: Claim, trials: int) -> float:
    """How likely trials at an end of the claim's region are called reproduced.

    A coin, or any other process of which the claim is false, passes at most as often as one at
    the nearest end.

    Args:
        claim: about a percentage.
        trials: how many, each a hit or not.
    """
    passing = [hits for hits in range(trials + 1) if claim.contains(_interval(hits, trials))]
    if not passing:
        return 0.0
    # Those that pass follow each other.
    first, last = passing[0], passing[-1]
    return max((_likelihood(first, last, trials, end / 100) for end in claim.ends), default=0.0)


def _interval(hits: float, trials: int) -> tuple[float, float]:
    low, high = exact_interval(hits, trials)
    return 100 * low, 100 * high


def _likelihood(first: int, last: int, trials: int, p: float) -> float:
    """How likely the number of hits is in a range, both ends included."""
    from scipy.special import bdtr

    p = min(max(p, 0.0), 1.0)
    return float(bdtr(last, trials, p) - (bdtr(first - 1, trials, p) if first else 0.0))
