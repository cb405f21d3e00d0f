"""Proportions: rates of events, with their uncertainty."""

from __future__ import annotations

#: Probability that an interval lies beyond the value on one side, by its construction.
TAIL = 0.025


def exact_interval(hits: float, trials: float) -> tuple[float, float]:
    """Return the Clopper-Pearson interval of a proportion.

    Args:
        hits: Number of successes; between integers, the bounds are interpolated by the beta law.
        trials: Number of trials, above 0; an effective number need not be an integer.

    Raises:
        ValueError: If there were no trials, or fewer than hits.
    """
    if not (0 <= hits <= trials and trials > 0):
        raise ValueError(f"{hits} of {trials} is not a proportion")
    from scipy.special import betaincinv

    lower = 0.0 if hits == 0 else float(betaincinv(hits, trials - hits + 1, TAIL))
    upper = 1.0 if hits == trials else float(betaincinv(hits + 1, trials - hits, 1 - TAIL))
    return lower, upper
