"""Reward of the learned policies without exploration (Figure 4.6 b)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.program import CheckedProgram
from cbdsl.api.sensing import KernelSample, bind
from cbdsl_reproduction.chapter_4.learning_curves import per_transition
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.interval import bootstrap_interval
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above
from cbdsl_reproduction.series import COARTICULATED, SEQUENTIAL, Series
from cbdsl_reproduction.trial_runner import LearnedTrial, TrialRunner, trial_runner, trials

Floats = NDArray[np.float64]

# Relative difference of rewards from which one policy earns clearly more.
_CLEARLY = 0.1
# Numbers of trials and episodes, as in the source.
_TRIALS, _EPISODES = 50, 10
_QUICK_TRIALS, _QUICK_EPISODES = 4, 2
# Context that requires a search, and bandwidth of a density that always finds the object, rad.
_SEARCHED, _EFFECTOR, _BANDWIDTH = "window", "head", 0.01
_PLACE = "Section 4.2.1, Figure 4.6 (b)"
_EARNS = Claim(_PLACE, "{series}: reward per transition", "", "drawn")
# The bound is a share of the earnings of the sequential policies.
_MORE = Claim(
    _PLACE,
    "reward per transition, co-articulated minus sequential",
    "",
    "clearly more",
    ordering=above(0),
    bound=above,
)
CLAIMS: Claims = {
    "fig-4.6b": (*(_EARNS.named(series=each.label) for each in (SEQUENTIAL, COARTICULATED)), _MORE)
}


def run(settings: RunSettings, name: str) -> Result:
    """Run the greedy policies with a first search that always finds the object."""
    with trial_runner(settings) as dexter:
        sequential, both = gather(dexter, settings, name)
    rewards_of = {SEQUENTIAL: sequential, COARTICULATED: both}
    alone = [_reward(series, rewards, settings.seed) for series, rewards in rewards_of.items()]
    quantities = (*alone, _gain(sequential, both, settings.seed))
    return Result(quantities, (_chart(name, rewards_of, settings.seed),), _NOTES)


def series_of(name: str) -> tuple[Series, ...]:
    """Return the series of trials."""
    return SEQUENTIAL, COARTICULATED


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> tuple[Floats, ...]:
    """Run all episodes, and return the rewards of each series; see ``_rewards``."""
    episodes = _QUICK_EPISODES if settings.quick else _EPISODES
    for series in series_of(name):
        for number in dexter.numbers(series):
            turns = _turns(settings, series, number)
            dexter.expect(dexter.episodes(series) + len(turns) * episodes)
    return tuple(_rewards(dexter, series, settings, episodes) for series in series_of(name))


def _turns(settings: RunSettings, series: Series, number: int) -> range:
    """Return the numbers of the trials without exploration that a trial's policy runs."""
    # With n learned policies, policy k runs the turns k, k + n, k + 2 n and so on.
    return range(number, _QUICK_TRIALS if settings.quick else _TRIALS, trials(settings, series))


def _rewards(dexter: TrialRunner, series: Series, settings: RunSettings, episodes: int) -> Floats:
    """Return rewards per transition, shape (trials, episodes); the learned policies take turns."""
    rows: dict[int, list[float]] = {}
    for learned in dexter.learn(series):
        turns = _turns(settings, series, learned.trial.number)
        seeds = learned.held_out(len(turns) * episodes)
        passed = dexter.greedy(learned, "finding", seeds, _finding(learned))
        rewards = [per_transition(each) for each in passed]
        for index, turn in enumerate(turns):
            rows[turn] = rewards[index * episodes : (index + 1) * episodes]
    return np.array([rows[turn] for turn in sorted(rows)])


def _finding(learned: LearnedTrial) -> CheckedProgram:
    """Return the program with the head's internal model narrowed to successful searches."""
    samples = tuple(
        experience.rewarded[_EFFECTOR]
        for experience in learned.trial.experiences
        if experience.context == _SEARCHED and _EFFECTOR in experience.rewarded
    )
    if not samples:
        return learned.trial.informed_program()
    source = KernelSample(_EFFECTOR, samples, (_BANDWIDTH,) * len(samples[0]), uniform=0.0)
    return bind(learned.trial.program, {f"{_EFFECTOR}.uniform": source})


def _reward(series: Series, rewards: Floats, seed: int) -> Quantity:
    note = f"{rewards.shape[0]} trials of {rewards.shape[1]} episodes"
    claim = _EARNS.named(series=series.label)
    return mean_of(claim, rewards.mean(axis=1).tolist(), seed=seed, note=note)


def _gain(sequential: Floats, both: Floats, seed: int) -> Quantity:
    """Return the additional reward of the co-articulated policies, with the claim about it."""
    differences = both.mean(axis=1) - sequential.mean(axis=1)
    level = float(sequential.mean())
    return mean_of(
        _MORE.at(_CLEARLY * level),
        differences.tolist(),
        seed=seed,
        note=f"clearly: by {100 * _CLEARLY:.0f} % of the earnings of the sequential ones",
    )


def _chart(name: str, rewards_of: Mapping[Series, Floats], seed: int) -> Chart:
    return Chart(
        name,
        "Reward per transition of the greedy policies",
        "episode",
        "reward per transition",
        tuple(_line(series, rewards, seed) for series, rewards in rewards_of.items()),
    )


def _line(series: Series, rewards: Floats, seed: int) -> Line:
    ends = [bootstrap_interval(column, seed) for column in rewards.T.tolist()]
    return Line(
        series.short,
        tuple(map(float, range(1, rewards.shape[1] + 1))),
        tuple(rewards.mean(axis=0).tolist()),
        tuple(low for low, _ in ends),
        tuple(high for _, high in ends),
    )


_NOTES = (
    "The policies of the trials take turns; none explores. As in the source the first search "
    "finds the object out of view: references are drawn from around the postures in which "
    "the head was rewarded in the context without an object. Both sets of actions meet the same "
    "episodes.",
)
