"""Proportions: how often something happens, and how sure that is."""

from __future__ import annotations

#: How often an interval lies beyond the value on one side, by its construction.
TAIL = 0.025


def exact_interval(hits: float, trials: float) -> tuple[float, float]:
    """Clopper-Pearson interval of a proportion.

    Args:
        hits: successes; between whole numbers the bounds are interpolated by the beta law.
        trials: how many there were, more than none; an effective number need not be whole.

    Raises:
        ValueError: there were no trials, or not as many as hits.
    """
    if not (0 <= hits <= trials and trials > 0):
        raise ValueError(f"{hits} of {trials} is no proportion")
    from scipy.special import betaincinv

    lower = 0.0 if hits == 0 else float(betaincinv(hits, trials - hits + 1, TAIL))
    upper = 1.0 if hits == trials else float(betaincinv(hits + 1, trials - hits, 1 - TAIL))
    return lower, upper
