"""Stable policies: after how many episodes what a trial would do no longer changes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from cbdsl.learning.experience import Experience
from cbdsl.reproduction.claim import Claim
from cbdsl.reproduction.estimate import estimate, median
from cbdsl.reproduction.interval import median_interval
from cbdsl.reproduction.quantity import Quantity
from cbdsl.reproduction.series import Series
from cbdsl.training.trial import Trial

# States that fewer of its transitions leave say little of a policy.
_LEAST = 0.05


def stable_after(trial: Trial, met: Iterable[Experience]) -> int:
    """From which episode on the greedy policy stays what it is at the end of a trial.

    Args:
        trial: at its end.
        met: episodes under its greedy policy, in whose states it counts.
    """
    states = _states(met)
    again = Trial(trial.program, trial.constants, trial.seed, trial.number)
    choices = []
    for experience in trial.experiences:
        again.replay(experience)
        greedy = again.learner.greedy()
        choices.append([greedy.get(state) for state in states])
    changes = [
        number for number in range(1, len(choices)) if choices[number] != choices[number - 1]
    ]
    return changes[-1] + 1 if changes else 1


def _states(met: Iterable[Experience]) -> list[str]:
    left = Counter(each.state for experience in met for each in experience.transitions)
    return [state for state, count in left.items() if count > _LEAST * left.total()]


def stable_quantity(
    series: Series, measured: Sequence[int], source: str, expected: Claim, seed: int
) -> Quantity:
    """The median over trials.

    Args:
        series: that was learned.
        measured: of each trial.
        source: what the source reports.
        expected: when the median counts as reproduced.
        seed: of the interval's resampling.
    """
    episodes = np.array(measured, dtype=float)
    return estimate(
        f"{series.label}: greedy policy is stable after, median",
        "episodes",
        source,
        episodes,
        median,
        lambda values: median_interval(values, seed),
        expected,
        seed=seed,
        note=f"{episodes.min():g} to {episodes.max():g}",
    )
