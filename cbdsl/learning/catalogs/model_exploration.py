"""Model-exploration programs: explorations by Q-learning over states of models (Section 6.3)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np

from cbdsl.documents.document import quantity
from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.exploration import Exploration, ExplorationStep
from cbdsl.learning.catalogs.exploration_constants import ExplorationConstants


class ModelConstants(ExplorationConstants):
    """Constants of a model-exploration program (Section 6.3)."""

    gamma: Annotated[float, quantity(ge=0, lt=1)] = 0.8
    """Discount."""
    epsilon: Annotated[float, quantity(ge=0, le=1)] = 0.05
    """Share of actions chosen at random."""
    promise: Annotated[float, quantity(ge=0, le=1)] = 0.2
    """Value at first of an action whose model is unknown or changing; the source has 0."""
    surprise: Annotated[float, quantity(gt=0)] = 4.0
    """From this Mahalanobis distance on, what is seen ahead is new to a model, which then counts as
    changing."""


# Model (Section 6.3): Q-learning over states with one letter per affordance model. Rewards shrink
# while models habituate, so that the best action changes during an exploration. A surprising
# observation sets the letter of its model back to 0. The values that were learned in that state
# then apply again.
class ModelExploration(Exploration):
    """Model-exploration program: Q-learning over the states of models (Eq 6.6)."""

    Constants: type[ExplorationConstants] = ModelConstants

    def __init__(
        self, actions: Mapping[str, Sequence[FeatureForm]], constants: ModelConstants
    ) -> None:
        self.table: dict[str, dict[str, float]] = {}
        super().__init__(actions, constants)
        self._settings = constants
        self._last = self.state

    @property
    def state(self) -> str:
        """One letter per model: X unknown, - undefined, 0 changing, 1 habituated (Eq 6.6)."""
        return "".join(map(self._predicate, self.affordances))

    def _predicate(self, name: str) -> str:
        affordance = self.affordances[name]
        if affordance.tried == 0:
            return "X"
        if not affordance.ahead:
            return "-"
        change = self.change_of(name)
        if change is None or affordance.distance() > self._settings.surprise:
            return "0"
        return "1" if change <= self._settings.habituated else "0"

    @property
    def values(self) -> dict[str, float]:
        """Expected reward of each action in the present state."""
        return self._row(self.state)

    def _row(self, state: str) -> dict[str, float]:
        """Return values in a state; actions not tried in it have the value their model promises."""
        promises = {
            name: self._settings.promise if letter in "X0" else 0.0
            for name, letter in zip(self.affordances, state, strict=False)
        }
        return {NOOP: 0.0, **promises, **self.table.get(state, {})}

    def choose(self, rng: np.random.Generator) -> str:
        """Return the next action; equal values are equally likely (see ``Exploration.choose``)."""
        names, self._last = self.actions, self.state
        if rng.random() < self._settings.epsilon:
            return names[int(rng.integers(len(names)))]
        own = self._row(self._last)
        best = max(own[name] for name in names)
        equal = [name for name in names if math.isclose(own[name], best, abs_tol=1e-12)]
        return equal[int(rng.integers(len(equal)))]

    def note(self, outcome: ActionOutcome) -> ExplorationStep:
        """Learn from the outcome of an action (see ``Exploration.note``)."""
        self._last = self.state
        return super().note(outcome)

    def learn(self, step: ExplorationStep) -> None:
        """Update the action's value (see ``Exploration.learn``)."""
        value = self._row(self._last)[step.action]
        ahead = self._row(self.state)
        best = max(ahead[name] for name in self.actions)
        target = step.reward + self._settings.gamma * best
        row = self.table.setdefault(self._last, {})
        row[step.action] = value + self._settings.alpha * (target - value)
