"""Groups of trials that differ in their seeds alone, and their curves."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.extend.backend import Floats
from cbdsl_report.interquartile import (
    Band,
    Center,
    band,
    interquartile_mean,
    mean,
    running_mean,
)
from cbdsl_report.learned_files import Learned

#: Numbers of episodes in the smoothing window.
WINDOWS = (1, 5, 10)


class TrialGroup(NamedTuple):
    """Trials that differ in their seeds alone.

    Attributes:
        name: Name of the group.
        trials: Trials, at least one.
    """

    name: str
    trials: tuple[Learned, ...]

    @property
    def episodes(self) -> int:
        """Number of episodes that all trials have."""
        # Trials of a group may differ in length, and curves over trials need all trials.
        return min(len(trial.curve.reward) for trial in self.trials)

    def rates(self) -> Floats:
        """Return reward per transition, by trial and episode, shape (trials, episodes)."""
        curves = [trial.curve for trial in self.trials]
        return self._table(
            [[r / n for r, n in zip(c.reward, c.transitions, strict=True)] for c in curves]
        )

    def hits(self) -> Floats:
        """Return 1 for rewarded episodes, else 0, shape (trials, episodes)."""
        return self._table([[float(r > 0) for r in trial.curve.reward] for trial in self.trials])

    def _table(self, rows: Sequence[Sequence[float]]) -> Floats:
        return np.array([row[: self.episodes] for row in rows], dtype=float)


class Measured(NamedTuple):
    """Curves of a group, by the number of episodes in the smoothing window.

    Attributes:
        group: Measured group.
        rate: Reward per transition, interquartile mean over trials.
        hits: Share of rewarded episodes, mean over trials.
    """

    group: TrialGroup
    rate: Mapping[int, Band]
    hits: Mapping[int, Band]


def measured(group: TrialGroup) -> Measured:
    """Return the curves of a group."""
    rate, hits = _curves(group.rates(), interquartile_mean), _curves(group.hits(), mean)
    return Measured(group, rate, hits)


def trial_groups(learned: Sequence[Learned]) -> list[TrialGroup]:
    """Return trials grouped by learning task and method, in the order of their first trial."""
    by_identity: dict[object, list[Learned]] = {}
    for each in learned:
        by_identity.setdefault(_identity(each), []).append(each)
    return [TrialGroup(_name(trials), tuple(trials)) for trials in by_identity.values()]


def _identity(learned: Learned) -> object:
    """Return the properties that distinguish groups; policies without provenance are alone."""
    provenance = learned.policy.provenance
    if provenance is None:
        return learned.file
    # All that influences learning separates groups, except for the seed, the length, and versions.
    return provenance.model_dump_json(exclude={"command", "seed", "trial", "episodes", "versions"})


def _name(trials: Sequence[Learned]) -> str:
    """Return the common part of the trials' names, without their numbers."""
    if len(trials) == 1:
        return trials[0].policy.name
    plain = {re.sub(r"_?\d+$", "", each.policy.name) for each in trials}
    return plain.pop() if len(plain) == 1 else f"{trials[0].policy.name} and others"


def _curves(values: Floats, center: Center) -> Mapping[int, Band]:
    """Return, by width of the window, a curve over trials; ``values`` are (trials, episodes).

    Each trial is smoothed before the trials are compared, so that the intervals are those of the
    drawn curves.
    """
    return {window: band(running_mean(values, window), center) for window in WINDOWS}
