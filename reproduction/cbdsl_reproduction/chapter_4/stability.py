"""Number of episodes after which the greedy policy of a trial stays constant."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from cbdsl.api.learning import Experience
from cbdsl.api.trials import Trial
from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.estimate import estimate, median
from cbdsl_reproduction.interval import median_interval
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import ValueRegion
from cbdsl_reproduction.series import Series

# Least share of transitions that leave a state for which the policy is compared.
_LEAST = 0.05


def stable_after(trial: Trial, met: Iterable[Experience]) -> int:
    """Return the episode from which the greedy policy equals the final one of a trial.

    Args:
        trial: Trial at its end.
        met: Episodes under its greedy policy; only their states are compared.
    """
    states = _states(met)
    # A learner keeps its final knowledge alone, so that a new one replays the episodes.
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


def stable_claim(place: str, series: Series, report: str, region: ValueRegion) -> Claim:
    """Return the claim about the median over the trials of a series."""
    name = f"{series.label}: greedy policy is stable after, median"
    return Claim(place, name, "episodes", report, region)


def stable_quantity(claim: Claim, measured: Sequence[int], seed: int) -> Quantity:
    """Return the median over trials.

    Args:
        claim: Claim about the median.
        measured: Number of episodes of each trial.
        seed: Seed of the resampling for the interval.
    """
    episodes = np.array(measured, dtype=float)
    return estimate(
        claim,
        episodes,
        median,
        lambda values: median_interval(values, seed),
        seed=seed,
        note=f"{episodes.min():g} to {episodes.max():g}",
    )
