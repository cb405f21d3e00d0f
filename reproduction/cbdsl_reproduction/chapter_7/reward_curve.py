"""Learning curve of PICKANDPLACE, in reward per state transition (Figure 7.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl_reproduction.chapter_4.learning_curves import per_transition
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import estimate
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.interval import interquartile_interval, interquartile_mean, interval_of
from cbdsl_reproduction.region import near
from cbdsl_reproduction.series import PICKANDPLACE, Series
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

Floats = NDArray[np.float64]

# Final episodes of a trial that define its level; level of the source's curve, by eye.
_LAST, _LEVEL, _TOLERANCE = 10, 0.15, 0.03
_APPROACHES = Claim(
    "Section 7.1.1, Figure 7.3",
    f"{PICKANDPLACE.label}: reward per transition in the last {_LAST} episodes",
    "",
    f"approaches {_LEVEL}",
    near(_LEVEL, _TOLERANCE),
)
CLAIMS: Claims = {"fig-7.3": (_APPROACHES,)}


def run(settings: RunSettings, name: str) -> Result:
    """Learn, and average the rewards during exploration."""
    with trial_runner(settings) as dexter:
        rewards = gather(dexter, settings, name)
    # Episodes of one trial depend on each other, so that a trial contributes one mean.
    level: Floats = rewards[:, -_LAST:].mean(axis=1)
    quantity = estimate(
        _APPROACHES,
        level,
        interquartile_mean,
        interval_of(interquartile_mean, settings.seed),
        seed=settings.seed,
        note=f"{len(rewards)} trials of {rewards.shape[1]} episodes, all of them exploring",
    )
    return Result((quantity,), (_chart(name, rewards, settings.seed),), _NOTES)


_NOTES = (
    "Interquartile means over the trials, with bootstrap intervals. An episode that comes to its "
    "reward without a detour has five transitions: the grasp begins and ends, the way to the goal "
    "begins, the place begins to bear the held object, and bears 2 N of it. It earns 0.2 per "
    "transition, which no exploring robot keeps up.",
)


def series_of(name: str) -> tuple[Series, ...]:
    """Return the series of trials."""
    return (PICKANDPLACE,)


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> Floats:
    """Run all episodes, and return the reward per transition, shape (trials, episodes)."""
    dexter.expect(len(dexter.numbers(PICKANDPLACE)) * dexter.episodes(PICKANDPLACE))
    trials = tuple(dexter.learn(PICKANDPLACE))
    return np.array([[per_transition(each) for each in one.trial.experiences] for one in trials])


def _chart(name: str, rewards: Floats, seed: int) -> Chart:
    low, high = interquartile_interval(rewards, seed)
    episodes = tuple(map(float, range(1, rewards.shape[1] + 1)))
    curve = Line(
        "PICKANDPLACE",
        episodes,
        tuple(interquartile_mean(rewards).tolist()),
        tuple(low.tolist()),
        tuple(high.tolist()),
    )
    ends = (episodes[0], episodes[-1])
    return Chart(
        name,
        f"Reward per transition while learning, {len(rewards)} trials",
        "episode",
        "reward per transition",
        (curve, Line("printed, in the end", ends, (_LEVEL, _LEVEL))),
    )
