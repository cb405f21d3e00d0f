"""Paired episodes of two programs, until the difference of their success rates is decided."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from cbdsl import EpisodeResult, RunRequest, UsageError, open_robot

# Probability that an interval lies beyond the proportion on one side.
_TAIL = 0.025


class EpisodePair(NamedTuple):
    """Results of two programs with the same seed."""

    seed: int
    first: EpisodeResult
    second: EpisodeResult

    @property
    def successes(self) -> tuple[bool, bool]:
        """Success of each of the two."""
        return self.first.succeeded, self.second.succeeded


@dataclass(frozen=True)
class ProgramComparison:
    """Pairs of episodes, and the difference of their success rates.

    Attributes:
        pairs: Pairs by seed.
        requested: Number of requested seeds; fewer pairs ran if that was decided before.
    """

    pairs: tuple[EpisodePair, ...]
    requested: int

    @property
    def counts(self) -> tuple[int, int]:
        """Number of successes of each program."""
        return (
            sum(pair.successes[0] for pair in self.pairs),
            sum(pair.successes[1] for pair in self.pairs),
        )

    @property
    def only(self) -> tuple[int, int]:
        """Numbers of seeds with which the first program alone succeeded, and the second alone."""
        return (
            sum(pair.successes == (True, False) for pair in self.pairs),
            sum(pair.successes == (False, True) for pair in self.pairs),
        )

    @property
    def difference(self) -> float:
        """Success rate of the second program minus that of the first."""
        first, second = self.only
        return (second - first) / len(self.pairs)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of the difference, which holds at all numbers of pairs simultaneously."""
        return difference_interval(*self.only, len(self.pairs))

    @property
    def p_value(self) -> float:
        """Exact two-sided p-value of McNemar's test; valid if all requested seeds ran."""
        from scipy.special import bdtr

        first, second = self.only
        return min(1.0, 2.0 * float(bdtr(min(first, second), first + second, 0.5)))

    @property
    def is_decided(self) -> bool:
        """True if the interval excludes 0."""
        low, high = self.interval
        return low > 0.0 or high < 0.0

    @property
    def first_differing(self) -> EpisodePair | None:
        """First pair of which one succeeded."""
        return next((p for p in self.pairs if p.successes[0] != p.successes[1]), None)


def anytime_interval(hits: int, trials: int, tail: float = _TAIL) -> tuple[float, float]:
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


# Model: pairs are independent, and a pair is discordant with the probability d. Given that, the
# second program is the better one with the probability q. The difference of the success rates is
# d (2 q - 1), and q is 1/2 without a difference (McNemar, 1947). Sequences of intervals of d and q,
# each of which misses with 2.5 %, hold together with 95 % at all numbers of pairs. To stop at the
# first interval without 0 therefore errs in at most 5 % of comparisons.
def difference_interval(first: int, second: int, pairs: int) -> tuple[float, float]:
    """Return the 95 % interval of a paired difference, at all numbers of pairs simultaneously.

    Args:
        first: Number of pairs in which the first alone succeeded.
        second: Number of pairs in which the second alone succeeded.
        pairs: Number of all pairs.
    """
    discordant = anytime_interval(first + second, pairs)
    low, high = (2.0 * end - 1.0 for end in anytime_interval(second, first + second))
    return (
        low * discordant[low < 0.0],
        high * discordant[high > 0.0],
    )


def is_open(first: int, second: int, pairs: int, left: int) -> bool:
    """Return whether the remaining pairs can still decide a comparison.

    Args:
        first: Number of pairs in which the first alone succeeded.
        second: Number of pairs in which the second alone succeeded.
        pairs: Number of all pairs.
        left: Number of remaining pairs.
    """
    best = difference_interval(first, second + left, pairs + left)[0]
    worst = difference_interval(first + left, second, pairs + left)[1]
    return best > 0.0 or worst < 0.0


def compare(
    first: str | Path | RunRequest,
    second: str | Path | RunRequest,
    *,
    seeds: Sequence[int],
    backends: tuple[str | None, str | None] = (None, None),
    cameras: str | None = None,
    stops_early: bool = True,
    on_pair: Callable[[EpisodePair], None] | None = None,
) -> ProgramComparison:
    """Run two programs with the same seeds, and compare their success rates.

    On one stage a seed gives both programs the same world. An episode succeeds as in ``evaluate``.

    Args:
        first: Result of ``load``, or a file or name for it.
        second: The same for the other program.
        seeds: Seeds of the pairs.
        backends: Names of the backends of the two.
        cameras: Kind of cameras, as for ``open_robot``.
        stops_early: True to end when the difference is decided, or cannot be decided any more.
        on_pair: Function called with each pair.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or there is no seed.
    """
    if not seeds:
        raise UsageError("a comparison needs at least one seed")
    pairs: list[EpisodePair] = []
    with (
        open_robot(first, backend=backends[0], cameras=cameras) as one,
        open_robot(second, backend=backends[1], cameras=cameras) as other,
    ):
        for seed in seeds:
            pairs.append(EpisodePair(seed, one.run(seed), other.run(seed)))
            if on_pair is not None:
                on_pair(pairs[-1])
            so_far = ProgramComparison(tuple(pairs), len(seeds))
            still = is_open(*so_far.only, len(pairs), len(seeds) - len(pairs))
            if stops_early and (so_far.is_decided or not still):
                break
    return ProgramComparison(tuple(pairs), len(seeds))
