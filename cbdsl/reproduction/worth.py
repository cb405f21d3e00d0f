"""Values of actions in the model that the transitions of all trials make."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.decisions import Decisions
from cbdsl.numeric.proportion import TAIL
from cbdsl.program.transition import Transition
from cbdsl.reproduction.claim import Interval, at_least, in_hindsight
from cbdsl.reproduction.quantity import Quantity
from cbdsl.reproduction.series import Series
from cbdsl.training.trial import Trial, used_programs

Floats = NDArray[np.float64]

#: Less than this share of another action's worth is not as good as it, %.
AS_GOOD = 95
# What was chosen less often than this says nothing, nor do trials so few that each of them has
# hardly tried anything but what it found first.
_LEAST, _LEAST_TRIALS = 5, 5
_DRAWS, _SWEEPS = 400, 200


@dataclass(frozen=True)
class Met:
    """The transitions of some trials, each counted any number of times.

    Attributes:
        pairs: the states and the actions that were chosen there.
        followed: how often which state followed, shape (trials, pairs, states).
        rewards: their sum, after which nothing follows, shape (trials, pairs).
        chosen: how often, shape (trials, pairs).
        origin: the place of each pair's state among the states, shape (pairs,).
    """

    pairs: tuple[tuple[str, str], ...]
    followed: Floats
    rewards: Floats
    chosen: Floats
    origin: NDArray[np.intp]

    def places(self, state: str) -> dict[str, int]:
        """The places of a state's pairs among all, by action."""
        return {action: place for place, (s, action) in enumerate(self.pairs) if s == state}

    def worth(self, gamma: float, times: NDArray[np.int64] | None = None) -> Floats:
        """Value of each pair if all later actions are the best; NaN where it was met too rarely.

        Args:
            gamma: discount.
            times: how often each trial counts, shape (trials,); once each where it is ``None``.
        """
        weights = np.ones(len(self.chosen)) if times is None else times
        chosen = weights @ self.chosen
        known = chosen >= _LEAST
        with np.errstate(invalid="ignore", divide="ignore"):
            followed = np.tensordot(weights, self.followed, 1) / chosen[:, None]
            rewards = weights @ self.rewards / chosen
        value = np.zeros(self.followed.shape[2])
        values = np.full(len(chosen), math.nan)
        for _ in range(_SWEEPS):
            values[known] = rewards[known] + gamma * followed[known] @ value
            value[:] = 0.0
            np.maximum.at(value, self.origin[known], values[known])
        return values


def met(trials: Sequence[Trial]) -> Met:
    """The transitions of the trials of a series."""
    each = [list(_decided(trial)) for trial in trials]
    every = [decision for decided in each for decision in decided]
    pairs = sorted({(decision.state, decision.action) for decision in every})
    states = sorted({state for d in every for state in (d.state, d.next_state)})
    place, number = {s: i for i, s in enumerate(states)}, {p: i for i, p in enumerate(pairs)}
    followed = np.zeros((len(trials), len(pairs), len(states)))
    rewards, chosen = np.zeros(followed.shape[:2]), np.zeros(followed.shape[:2])
    for trial, decided in enumerate(each):
        for decision in decided:
            pair = number[decision.state, decision.action]
            chosen[trial, pair] += 1
            rewards[trial, pair] += decision.reward
            followed[trial, pair, place[decision.next_state]] += decision.reward == 0
    origin = np.array([place[state] for state, _ in pairs], dtype=np.intp)
    return Met(tuple(pairs), followed, rewards, chosen, origin)


def shares_of(trials: Sequence[Trial]) -> dict[str, dict[str, float]]:
    """Worth of each action in each state, in % of that of the best one there.

    Args:
        trials: of Algorithm 1; of fewer than five nothing is told.

    Returns:
        Shares by state and action, of those that were chosen often enough.
    """
    if len(trials) < _LEAST_TRIALS:
        return {}
    tallies = met(trials)
    worth = tallies.worth(_discount(trials))
    return {state: _shares(worth, tallies.places(state)) for state, _ in tallies.pairs}


def worth_quantities(
    series: Series, trials: Sequence[Trial], choices: Sequence[tuple[str, str]], seed: int
) -> Iterator[Quantity]:
    """Whether what the source's policy chooses is worth as much as anything else there.

    Args:
        series: that was learned.
        trials: of it; there are no quantities of fewer than five.
        choices: states, and the actions that the source's policy chooses there.
        seed: of the interval's resampling of trials.
    """
    if len(trials) < _LEAST_TRIALS:
        return
    tallies, gamma = met(trials), _discount(trials)
    rng, count = np.random.default_rng(seed), len(trials)
    times = rng.multinomial(count, np.full(count, 1 / count), size=_DRAWS)
    whole, drawn = tallies.worth(gamma), [tallies.worth(gamma, each) for each in times]
    for state, action in choices:
        here = tallies.places(state)
        shares = _shares(whole, here)
        others = [f"{name} {share:.0f}" for name, share in shares.items() if name != action]
        yield Quantity(
            f"{series.label}: worth of {action} in {state}, relative to the best action",
            "%",
            "chosen",
            shares.get(action, math.nan),
            in_hindsight(at_least(AS_GOOD)),
            chance=TAIL,
            interval=_spread([_shares(each, here).get(action, math.nan) for each in drawn]),
            note=f"others: {', '.join(others)}" if others else "",
        )


def _discount(trials: Sequence[Trial]) -> float:
    constants = trials[0].constants
    assert isinstance(constants, AccommodateConstants), "values are those of Algorithm 1"
    return constants.gamma


def _decided(trial: Trial) -> Iterator[Transition]:
    """The decisions of a trial, whatever is behind them."""
    decisions = Decisions(used_programs(trial.program))
    for experience in trial.experiences:
        for transition in experience.transitions:
            over = decisions.over(transition)
            if over is not None:
                yield over


def _shares(worth: Floats, here: Mapping[str, int]) -> dict[str, float]:
    """Of each action of a state that was chosen often enough, its worth in % of the best one's."""
    known = {action: worth[place] for action, place in here.items() if worth[place] >= 0}
    best = max(known.values(), default=0.0)
    if len(known) < 2 or best == 0.0:  # there is nothing to compare with
        return {}
    return {action: float(100 * value / best) for action, value in known.items()}


def _spread(shares: Sequence[float]) -> Interval | None:
    known = [share for share in shares if not math.isnan(share)]
    if not known:
        return None
    low, high = np.percentile(known, (2.5, 97.5))
    return float(low), float(high)
