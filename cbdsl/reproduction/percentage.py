"""A percentage of trials as a quantity."""

from __future__ import annotations

import math

from cbdsl.reproduction.interval import exact_interval
from cbdsl.reproduction.quantity import Claim, Quantity


def percentage(
    name: str,
    source: str,
    hits: int,
    trials: int,
    expected: Claim,
    *,
    ordering: Claim | None = None,
    of: str = "",
    note: str = "",
) -> Quantity:
    """The percentage of trials that are hits, with its exact interval.

    Args:
        name, source, expected, ordering: see ``Quantity``.
        hits: successes.
        trials: all trials; of none the quantity is NaN.
        of: a word for the trials in the note.
        note: follows the counts in the note.
    """
    low, high = exact_interval(hits, trials) if trials else (math.nan, math.nan)
    counts = f"{hits} of {trials}{of and ' '}{of}"
    return Quantity(
        name,
        "%",
        source,
        100 * hits / trials if trials else math.nan,
        expected,
        ordering,
        (100 * low, 100 * high) if trials else None,
        f"{counts}; {note}" if note else counts,
    )
