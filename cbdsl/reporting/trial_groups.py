"""Groups of trials that differ in their seeds alone, and their curves."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.reporting.interquartile import (
    Band,
    Center,
    band,
    interquartile_mean,
    mean,
    running_mean,
)
from cbdsl.reporting.learned import Learned

Floats = NDArray[np.float64]

#: Over how many episodes curves can be smoothed.
WINDOWS = (1, 5, 10)


class TrialGroup(NamedTuple):
    """Trials that differ in their seeds alone.

    Attributes:
        name: of all of them.
        trials: at least one.
    """

    name: str
    trials: tuple[Learned, ...]

    @property
    def episodes(self) -> int:
        """The number of episodes that all trials have."""
        return min(len(trial.episodes) for trial in self.trials)

    def rates(self) -> Floats:
        """Reward per transition, by trial and episode, shape (trials, episodes)."""
        return self._table([[e.reward / e.transitions for e in t.episodes] for t in self.trials])

    def hits(self) -> Floats:
        """1 where an episode was rewarded, else 0, shape (trials, episodes)."""
        return self._table([[float(e.reward > 0) for e in t.episodes] for t in self.trials])

    def _table(self, rows: Sequence[Sequence[float]]) -> Floats:
        return np.array([row[: self.episodes] for row in rows], dtype=float)


class Measured(NamedTuple):
    """The curves of a group, by the number of episodes that they are smoothed over.

    Attributes:
        group: the group.
        rate: reward per transition, the interquartile mean over trials.
        hits: share of rewarded episodes, the mean over trials.
    """

    group: TrialGroup
    rate: Mapping[int, Band]
    hits: Mapping[int, Band]


def measured(group: TrialGroup) -> Measured:
    """The curves of a group."""
    rate, hits = _curves(group.rates(), interquartile_mean), _curves(group.hits(), mean)
    return Measured(group, rate, hits)


def trial_groups(learned: Sequence[Learned]) -> list[TrialGroup]:
    """Trials by what was learned where and how, in the order of the first of each."""
    by_identity: dict[object, list[Learned]] = {}
    for each in learned:
        by_identity.setdefault(_identity(each), []).append(each)
    return [TrialGroup(_name(trials), tuple(trials)) for trials in by_identity.values()]


def _identity(learned: Learned) -> object:
    """The properties that distinguish groups; policies without provenance are alone."""
    provenance = learned.policy.provenance
    if provenance is None:
        return learned.file
    return provenance.model_dump_json(exclude={"command", "seed", "trial", "episodes", "versions"})


def _name(trials: Sequence[Learned]) -> str:
    """The common part of the trials' names, without their numbers."""
    if len(trials) == 1:
        return trials[0].policy.name
    plain = {re.sub(r"_?\d+$", "", each.policy.name) for each in trials}
    return plain.pop() if len(plain) == 1 else f"{trials[0].policy.name} and others"


def _curves(values: Floats, center: Center) -> Mapping[int, Band]:
    """By width of the window, a curve over trials; ``values`` have shape (trials, episodes).

    Each trial is smoothed before trials are compared, so that intervals are those of what is drawn.
    """
    return {window: band(running_mean(values, window), center) for window in WINDOWS}
