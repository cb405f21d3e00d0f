"""Proportions: rates of events, with their uncertainty."""

from __future__ import annotations

import math

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


def anytime_interval(hits: int, trials: int, tail: float = TAIL) -> tuple[float, float]:
    """Return an interval of a proportion that holds at all numbers of trials simultaneously.

    Trials may therefore stop as soon as the interval has excluded a value.

    Args:
        hits: Number of successes.
        trials: Number of independent trials; 0 gives the interval from 0 to 1.
        tail: Probability that any interval of the sequence misses the proportion.

    Raises:
        ValueError: If there were fewer trials than hits.
    """
    if not 0 <= hits <= trials:
        raise ValueError(f"{hits} of {trials} is not a proportion")
    from scipy.optimize import brentq
    from scipy.special import betaln, xlog1py, xlogy

    # The mixture martingale of Robbins (1970): the likelihood of the trials, averaged over all
    # proportions q, over that of one proportion p,
    #     M(p) = B(h + 1, n - h + 1) / (p^h (1 - p)^(n - h)).
    # If p is the proportion, M(p) has the mean 1, and by Ville's inequality it ever exceeds
    # 1 / tail with at most the probability tail. The interval holds all p with M(p) below that.
    def excess(p: float) -> float:
        likelihood = xlogy(hits, p) + xlog1py(trials - hits, -p)
        return float(betaln(hits + 1, trials - hits + 1) - likelihood + math.log(tail))

    best = hits / trials if trials else 0.5
    lower = brentq(excess, 1e-300, best) if hits else 0.0
    upper = brentq(excess, best, 1.0 - 1e-16) if hits < trials else 1.0
    return float(lower), float(upper)
