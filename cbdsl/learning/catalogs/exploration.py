"""Exploration of affordances: choice of actions and models of their outcomes (Chapter 6)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.affordance import Affordance
from cbdsl.learning.catalogs.exploration_constants import ExplorationConstants
from cbdsl.runtime.episode_observer import EpisodeObserver


class ExplorationObserver(EpisodeObserver):
    """Observer of an exploration; the world waits during each call."""

    def note_choice(self, name: str) -> None:
        """Note that an action was chosen and runs next."""

    def note_step(self, exploration: Exploration) -> None:
        """Note that an action is over, whether new or replayed from the journal."""


class ExplorationStep(NamedTuple):
    """Evaluation of an outcome by an exploration.

    Attributes:
        action: Action that was taken.
        rewarded: True if the action was rewarded.
        change: Change of the model's variance, in units of the prior's.
        reward: Reward by Eq 6.2: the change relative to the largest so far, minus the cost.
    """

    action: str
    rewarded: bool
    change: float
    reward: float


class Exploration(ABC):
    """Choice of actions by their expected information, and models of their affordances.

    All knowledge follows from the noted outcomes, in their order.

    Args:
        actions: Forms of the actions' features, by name; ``noop`` is added.
        constants: Constants of the algorithm.

    Attributes:
        affordances: Affordance of each action except noop, by name.
        steps: Steps so far.
        constants: Constants of the algorithm.
    """

    Constants: type[ExplorationConstants] = ExplorationConstants

    def __init__(
        self, actions: Mapping[str, Sequence[FeatureForm]], constants: ExplorationConstants
    ) -> None:
        self.constants = constants
        self.affordances: dict[str, Affordance] = {}
        self.steps: list[ExplorationStep] = []
        self._largest = 0.0
        for name, forms in actions.items():
            self.affordances[name] = Affordance(tuple(forms))

    @property
    def actions(self) -> list[str]:
        """Names of the actions that can be taken now; noop is the last."""
        return [*(n for n, each in self.affordances.items() if not each.failed), NOOP]

    @abstractmethod
    def choose(self, rng: np.random.Generator) -> str:
        """Return the next action."""

    @abstractmethod
    def learn(self, step: ExplorationStep) -> None:
        """Learn from the reward of a step after the models were updated."""

    def add(self, actions: Mapping[str, Sequence[FeatureForm]]) -> None:
        """Add unknown actions, such as actions that another one made possible."""
        for name, forms in actions.items():
            self.affordances.setdefault(name, Affordance(tuple(forms)))

    def note(self, outcome: ActionOutcome) -> ExplorationStep:
        """Learn from the outcome of an action (Algorithm 3, lines 10 to 21)."""
        if outcome.action == NOOP:
            step = ExplorationStep(NOOP, False, 0.0, 0.0)
        else:
            change = self.affordances[outcome.action].note(outcome, self.constants)
            change = change if outcome.rewarded else 0.0
            self._largest = max(self._largest, change)
            # Changes have no natural unit. Relative to the largest one, they compare with the cost.
            share = change / self._largest if self._largest else 0.0
            step = ExplorationStep(
                outcome.action, outcome.rewarded, change, share - self.constants.cost
            )
        for name, affordance in self.affordances.items():
            affordance.ahead = outcome.ahead.get(name, {})
        self.steps.append(step)
        self.learn(step)
        return step

    def change_of(self, name: str) -> float | None:
        """Return a model's last variance change relative to the largest so far, or ``None``."""
        change = self.affordances[name].change
        return None if change is None or not self._largest else change / self._largest

    def is_habituated(self, name: str) -> bool:
        """Return whether an action was tried often enough and its model hardly changes any more."""
        affordance = self.affordances[name]
        change = self.change_of(name)
        calm = change is None or change < self.constants.habituated
        return affordance.failed or (affordance.tried >= self.constants.least and calm)

    @property
    def is_over(self) -> bool:
        """Whether all models have habituated (Algorithm 3, line 22)."""
        return all(map(self.is_habituated, self.affordances))
