"""Proportions: how often something happens, and how sure that is."""

from __future__ import annotations

import math

# Of the normal distribution, beyond which 2.5 % lie on either side.
_QUANTILE = 1.959963984540054


def wilson_interval(hits: int, trials: int) -> tuple[float, float]:
    """Wilson's interval of 95 % of a proportion.

    Args:
        hits: successes.
        trials: how many there were, at least one.

    Raises:
        ValueError: there were no trials, or not as many as hits.
    """
    if not (0 <= hits <= trials and trials > 0):
        raise ValueError(f"{hits} of {trials} is no proportion")
    share, spread = hits / trials, _QUANTILE**2 / trials
    middle = (share + spread / 2) / (1 + spread)
    half = math.sqrt(share * (1 - share) / trials * _QUANTILE**2 + spread**2 / 4) / (1 + spread)
    return round(max(0.0, middle - half), 6), round(min(1.0, middle + half), 6)
