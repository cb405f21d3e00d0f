"""Learning curves without co-articulation and with it (Figure 4.6 a)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.learning import Experience
from cbdsl_reproduction.chapter_4.checks import Check, checks, schedule
from cbdsl_reproduction.chapter_4.learned_in import learned_in_claims, learned_in_quantities
from cbdsl_reproduction.chapter_4.stability import stable_after, stable_claim, stable_quantity
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import estimate
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.interval import (
    TAIL,
    interquartile_interval,
    interquartile_mean,
    interval_of,
)
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, near
from cbdsl_reproduction.series import COARTICULATED, SEQUENTIAL, Series
from cbdsl_reproduction.trial_runner import LearnedTrial, TrialRunner, trial_runner

Floats = NDArray[np.float64]

# Final episodes of a trial that define its level. A curve, smoothed over a few episodes, has
# settled once it stays above a share of that level.
_LAST, _WINDOW, _SETTLED = 20, 5, 0.8
_DRAWS = 2000
# Relative difference of rewards up to which two learners count as equally good.
_HARDLY = 0.1

_PLACE = "Section 4.2.1, Figure 4.6 (a)"
_REPORTED = {
    SEQUENTIAL: ("about 10 episodes", near(10, 4)),
    COARTICULATED: ("about 20 episodes", near(20, 5)),
}
_LEARNED = {
    series: learned_in_claims(_PLACE, series, *reported) for series, reported in _REPORTED.items()
}
_STABLE = {
    series: stable_claim(_PLACE, series, *reported) for series, reported in _REPORTED.items()
}
_LATER = Claim(
    _PLACE,
    "episodes until the curve stays at its level, co-articulated by sequential",
    "",
    "about 20 by about 10",
    near(2, 0.5),
    above(1),
)
# The bound is a share of the earnings of the sequential trials.
_AS_MUCH = Claim(
    _PLACE,
    f"reward per transition in the last {_LAST} episodes, co-articulated minus sequential",
    "",
    "slightly above 0, not significantly",
    bound=partial(near, 0),
)
CLAIMS: Claims = {
    "fig-4.6a": (
        *(claim for series in _REPORTED for claim in (*_LEARNED[series], _STABLE[series])),
        _LATER,
        _AS_MUCH,
    )
}


@dataclass(frozen=True)
class Curves:
    """Results of the trials of a series.

    Attributes:
        series: Learned series.
        trials: Trials at their ends.
        checks: Checks of each trial.
    """

    series: Series
    trials: tuple[LearnedTrial, ...]
    checks: tuple[tuple[Check, ...], ...]

    @property
    def rewards(self) -> Floats:
        """Reward per transition while exploring, shape (trials, episodes)."""
        return np.array(
            [[per_transition(each) for each in one.trial.experiences] for one in self.trials]
        )

    @property
    def level(self) -> Floats:
        """Mean reward per transition of the last episodes, shape (trials,)."""
        level: Floats = self.rewards[:, -_LAST:].mean(axis=1)
        return level


def per_transition(experience: Experience) -> float:
    """Return the reward per state transition, the measure of Figure 4.6."""
    return experience.reward / len(experience.transitions)


def run(settings: RunSettings, name: str) -> Result:
    """Learn with both sets of actions, and check the greedy policies during learning."""
    with trial_runner(settings) as dexter:
        sequential, both = gather(dexter, settings, name)
    quantities = (
        *_learned(sequential, settings.seed),
        *_learned(both, settings.seed),
        _times(sequential, both, settings.seed),
        _advantage(sequential, both, settings.seed),
    )
    groups = (sequential, both)
    return Result(quantities, (_chart(name, groups, settings.seed),), _notes(settings, groups))


def _learned(curves: Curves, seed: int) -> Iterator[Quantity]:
    """Yield the numbers of episodes until a series is learned, and until its policy is stable."""
    series = curves.series
    yield from learned_in_quantities(series, curves.checks, _LEARNED[series], seed)
    stable = [
        stable_after(each.trial, checks[-1].experiences)
        for each, checks in zip(curves.trials, curves.checks, strict=True)
    ]
    yield stable_quantity(_STABLE[series], stable, seed)


def series_of(name: str) -> tuple[Series, ...]:
    """Return the series of trials."""
    return SEQUENTIAL, COARTICULATED


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> tuple[Curves, ...]:
    """Run all episodes, and return the results of each series."""
    for series in series_of(name):
        _expect(dexter, series, settings)
    return tuple(_curves(dexter, series, settings) for series in series_of(name))


def _expect(dexter: TrialRunner, series: Series, settings: RunSettings) -> None:
    plan, episodes = schedule(settings), dexter.episodes(series)
    each = episodes + plan.held_out * len(plan.after(episodes))
    dexter.expect(len(dexter.numbers(series)) * each)


def _curves(dexter: TrialRunner, series: Series, settings: RunSettings) -> Curves:
    plan = schedule(settings)
    trials = tuple(dexter.learn(series))
    return Curves(series, trials, tuple(checks(dexter, each, plan) for each in trials))


def _times(sequential: Curves, both: Curves, seed: int) -> Quantity:
    """Return the ratio of the settling times of the larger and the smaller set of actions."""
    once, twice = settled_at(sequential.rewards), settled_at(both.rewards)
    rng = np.random.default_rng(seed)
    # A settling time belongs to the mean curve of a series, so that each series is resampled as a
    # whole.
    ratios = [
        settled_at(_resampled(both.rewards, rng)) / settled_at(_resampled(sequential.rewards, rng))
        for _ in range(_DRAWS)
    ]
    low, high = np.percentile(ratios, (2.5, 97.5))
    return Quantity(
        _LATER,
        twice / once,
        interval=(float(low), float(high)) if len(both.trials) > 1 else None,
        chance=TAIL,
        note=f"{twice} by {once} episodes",
    )


def settled_at(rewards: Floats) -> int:
    """Return the episode from which a learning curve stays at its level.

    From there, the mean over five episodes stays above 80 % of the mean over the last twenty.

    Args:
        rewards: Rewards per transition, shape (trials, episodes).
    """
    curve = interquartile_mean(rewards)
    level = _SETTLED * curve[-_LAST:].mean()
    smooth = np.convolve(curve, np.full(_WINDOW, 1 / _WINDOW), mode="valid")
    # Window k, counted from 0, begins with episode k + 1. The curve has settled from the window
    # after the last low one.
    below = np.flatnonzero(smooth < level)
    return int(below[-1]) + 2 if len(below) else 1


def _resampled(rewards: Floats, rng: np.random.Generator) -> Floats:
    drawn: Floats = rewards[rng.integers(len(rewards), size=len(rewards))]
    return drawn


def _advantage(sequential: Curves, both: Curves, seed: int) -> Quantity:
    """Return the additional final reward of the co-articulated trials, while both explore.

    With few trials, no difference would be significant either. The claim therefore requires that
    the whole interval is close to zero.
    """
    margin = _HARDLY * float(interquartile_mean(sequential.level))
    ends = f"{interquartile_mean(both.level):.3f} and {interquartile_mean(sequential.level):.3f}"
    return estimate(
        _AS_MUCH.at(margin),
        both.level - sequential.level,
        interquartile_mean,
        interval_of(interquartile_mean, seed),
        seed=seed,
        note=f"{ends}; hardly: by {100 * _HARDLY:.0f} % of the best sequential earnings",
    )


def _chart(name: str, groups: Sequence[Curves], seed: int) -> Chart:
    return Chart(
        name,
        f"Reward per transition while learning, {len(groups[0].trials)} trials",
        "episode",
        "reward per transition",
        tuple(_line(curves, seed) for curves in groups),
    )


def _line(curves: Curves, seed: int) -> Line:
    rewards = curves.rewards
    low, high = interquartile_interval(rewards, seed)
    return Line(
        curves.series.short,
        tuple(map(float, range(1, rewards.shape[1] + 1))),
        tuple(interquartile_mean(rewards).tolist()),
        tuple(low.tolist()),
        tuple(high.tolist()),
    )


def _notes(settings: RunSettings, groups: Sequence[Curves]) -> tuple[str, ...]:
    plan = schedule(settings)
    return (
        "Interquartile means over the trials, with bootstrap intervals. Learned in: the first of "
        f"three checks in a row, one every {plan.every} episodes, at which the greedy policy was "
        f"rewarded in 95 % of {plan.held_out} episodes that it did not learn from.",
        "The greedy policy is looked at after each episode, in the states that more than 5 % of "
        "its transitions leave at the last check.",
        f"A curve stays at its level from where its mean over {_WINDOW} episodes stays above "
        f"{100 * _SETTLED:.0f} % of its last {_LAST} episodes; the source names them by eye.",
        *(_effort(curves) for curves in groups),
    )


def _effort(curves: Curves) -> str:
    """Return a sentence about the cost of a trial."""
    costs = np.array([_cost(each) for each in curves.trials])
    reward, transitions, ticks, simulated, wall = interquartile_mean(costs)
    return (
        f"A trial of {curves.series.label} has {curves.rewards.shape[1]} episodes with a reward of "
        f"{reward:.0f} in {transitions:.0f} transitions, {ticks:.0f} control ticks, "
        f"{simulated:.0f} simulated seconds and {wall:.0f} s of wall time (interquartile means)."
    )


def _cost(learned: LearnedTrial) -> tuple[float, ...]:
    """Return reward, transitions, control ticks, simulated seconds and wall seconds of a trial."""
    experiences = learned.trial.experiences
    return (
        sum(each.reward for each in experiences),
        sum(len(each.transitions) for each in experiences),
        sum(each.ticks for each in experiences),
        sum(each.sim_seconds for each in experiences),
        sum(each.wall_seconds for each in experiences),
    )
