"""A percentage of trials as a quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cbdsl.numeric.proportion import TAIL, exact_interval
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
    return _share(name, source, hits, trials, expected, ordering, noted, judged=trials > 1)


def clustered_percentage(
    name: str,
    source: str,
    hits: Sequence[int],
    sizes: Sequence[int],
    expected: Claim | None,
    *,
    ordering: Claim | None = None,
    of: str = "",
    note: str = "",
) -> Quantity:
    """The percentage of hits that come several to a trial, and depend on each other there.

    The interval is the exact one of the effective number of outcomes (Korn and Graubard, 1998):
    as many independent ones as would vary as these vary between trials. Where all or none are hits
    nothing varies, and only the number of trials limits what is known.

    Args:
        name, source, expected, ordering, note: see ``Quantity``; claims are about percentages.
        hits: of each trial.
        sizes: all outcomes of each trial; of a single trial the quantity is not judged.
        of: a word for the outcomes in the note.
    """
    total, right, trials = sum(sizes), sum(hits), sum(size > 0 for size in sizes)
    noted = f"{right} of {total}{of and ' '}{of} in {len(sizes)} trials{note and '; '}{note}"
    outcomes = effective_number(hits, sizes) if trials > 1 else float(trials)
    known = right / total * outcomes if total else 0.0
    return _share(name, source, known, outcomes, expected, ordering, noted, judged=trials > 1)


def effective_number(hits: Sequence[int], sizes: Sequence[int]) -> float:
    """Effective number of the outcomes of at least two trials that have any.

    Args:
        hits: of each trial.
        sizes: all outcomes of each trial.

    Returns:
        At most the number of outcomes; less for fewer trials, whose spread is known less well.
    """
    from scipy.special import stdtrit

    total, trials = sum(sizes), sum(size > 0 for size in sizes)
    share = sum(hits) / total
    squares = sum((hit - share * size) ** 2 for hit, size in zip(hits, sizes, strict=True))
    variance = trials / (trials - 1) * squares / total**2
    number = share * (1 - share) / variance if variance > 0 else math.inf
    known = float(stdtrit(total - 1, 1 - TAIL) / stdtrit(trials - 1, 1 - TAIL)) ** 2
    return min(number, total) * known


def _share(
    name: str,
    source: str,
    hits: float,
    trials: float,
    expected: Claim | None,
    ordering: Claim | None,
    note: str,
    *,
    judged: bool,
) -> Quantity:
    return Quantity(
        name,
        "%",
        source,
        100 * hits / trials if trials else math.nan,
        expected,
        ordering,
        _interval(hits, trials) if judged else None,
        chance_of_counts(expected, math.ceil(trials)) if expected is not None and trials else 0.0,
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


def _interval(hits: float, trials: float) -> tuple[float, float]:
    low, high = exact_interval(hits, trials)
    return 100 * low, 100 * high


def _likelihood(first: int, last: int, trials: int, p: float) -> float:
    """How likely the number of hits is in a range, both ends included."""
    from scipy.special import bdtr

    p = min(max(p, 0.0), 1.0)
    return float(bdtr(last, trials, p) - (bdtr(first - 1, trials, p) if first else 0.0))
