"""Values of actions in the model formed by the transitions of all trials."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl import Transition
from cbdsl.api.learning import AccommodateConstants, Decisions
from cbdsl.api.trials import Trial, used_programs
from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.interval import TAIL
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import Interval, at_least, in_hindsight
from cbdsl_reproduction.series import Series

Floats = NDArray[np.float64]

#: Least share of another action's worth at which an action counts as equally good, %.
AS_GOOD = 95
# Least number of choices of an action and of trials for a reliable value. In too few trials,
# hardly any action is tried beyond the first rewarded one.
_LEAST, _LEAST_TRIALS = 5, 5
_DRAWS, _SWEEPS = 400, 200


@dataclass(frozen=True)
class Met:
    """Transitions of some trials, each of which can be weighted.

    Attributes:
        pairs: States and the actions that were chosen there.
        followed: Counts of the next states, shape (trials, pairs, states).
        rewards: Sums of the rewards; a reward ends the sequence; shape (trials, pairs).
        chosen: Numbers of choices, shape (trials, pairs).
        origin: Index of each pair's state among the states, shape (pairs,).
    """

    pairs: tuple[tuple[str, str], ...]
    followed: Floats
    rewards: Floats
    chosen: Floats
    origin: NDArray[np.intp]

    def places(self, state: str) -> dict[str, int]:
        """Return the indices of a state's pairs, by action."""
        return {action: place for place, (s, action) in enumerate(self.pairs) if s == state}

    def worth(self, gamma: float, times: NDArray[np.int64] | None = None) -> Floats:
        """Return the value of each pair if all later actions are optimal; NaN for rare pairs.

        Args:
            gamma: Discount factor.
            times: Weight of each trial, shape (trials,); ``None`` for equal weights of 1.
        """
        # Value iteration on the model that the counts of all trials form:
        #     Q(s, a) = r(s, a) + gamma sum_s' p(s' | s, a) max_a' Q(s', a')
        # A rewarded decision ends its sequence. It counts as a choice but leads to no next state,
        # so that the probabilities p add up to less than 1. Assumption: the trials are samples of
        # the same decision process, independently of their exploration.
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
    """Count the transitions of the trials of a series."""
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
    """Return the worth of each action in each state, in % of the best action there.

    Args:
        trials: Trials of Algorithm 1, at least five.

    Returns:
        Shares by state and action, for actions chosen often enough; empty for too few trials.
    """
    if len(trials) < _LEAST_TRIALS:
        return {}
    tallies = met(trials)
    worth = tallies.worth(_discount(trials))
    return {state: _shares(worth, tallies.places(state)) for state, _ in tallies.pairs}


def worth_claims(
    place: str, series: Series, choices: Iterable[tuple[str, str]]
) -> dict[tuple[str, str], Claim]:
    """Return the claims that a series chooses actions in states, by state and action."""
    region = in_hindsight(at_least(AS_GOOD))
    name = f"{series.label}: worth of {{action}} in {{state}}, relative to the best action"
    every = Claim(place, name, "%", "chosen", region)
    return {(state, action): every.named(state=state, action=action) for state, action in choices}


def worth_quantities(
    claims: Mapping[tuple[str, str], Claim], trials: Sequence[Trial], seed: int
) -> Iterator[Quantity]:
    """Yield the worth of the source's choices relative to the best action in each state.

    Args:
        claims: Claims by state, and the action that the source's policy chooses there.
        trials: Trials of the series; fewer than five yield no quantities.
        seed: Seed of the resampling of trials for the interval.
    """
    if len(trials) < _LEAST_TRIALS:
        return
    tallies, gamma = met(trials), _discount(trials)
    rng, count = np.random.default_rng(seed), len(trials)
    # A bootstrap draw of whole trials is a multinomial weight of each. Single transitions are no
    # independent samples.
    times = rng.multinomial(count, np.full(count, 1 / count), size=_DRAWS)
    whole, drawn = tallies.worth(gamma), [tallies.worth(gamma, each) for each in times]
    for (state, action), claim in claims.items():
        here = tallies.places(state)
        shares = _shares(whole, here)
        others = [f"{name} {share:.0f}" for name, share in shares.items() if name != action]
        yield Quantity(
            claim,
            shares.get(action, math.nan),
            chance=TAIL,
            interval=_spread([_shares(each, here).get(action, math.nan) for each in drawn]),
            note=f"others: {', '.join(others)}" if others else "",
        )


def _discount(trials: Sequence[Trial]) -> float:
    constants = trials[0].constants
    assert isinstance(constants, AccommodateConstants), "values are those of Algorithm 1"
    return constants.gamma


def _decided(trial: Trial) -> Iterator[Transition]:
    """Yield the decisions of a trial, as transitions over complete actions."""
    decisions = Decisions(used_programs(trial.program))
    for experience in trial.experiences:
        for transition in experience.transitions:
            over = decisions.over(transition)
            if over is not None:
                yield over


def _shares(worth: Floats, here: Mapping[str, int]) -> dict[str, float]:
    """Return the worth of a state's actions chosen often enough, in % of the best one."""
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
