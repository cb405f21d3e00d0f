"""EXPLORECATALOG: an exploration by a softmax bandit (Algorithm 3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np

from cbdsl.documents.document import quantity
from cbdsl.learning.catalogs.action_outcome import FeatureForm
from cbdsl.learning.catalogs.exploration import Exploration, ExplorationStep
from cbdsl.learning.catalogs.exploration_constants import ExplorationConstants


class CatalogConstants(ExplorationConstants):
    """Constants of EXPLORECATALOG (Algorithm 3)."""

    temperature: Annotated[float, quantity(gt=0)] = 0.3
    """Temperature tau of the first choice; the source has 1."""
    decay: Annotated[float, quantity(gt=0, le=1)] = 0.96
    """Factor of the temperature from one choice to the next; the source has 0.99."""
    coldest: Annotated[float, quantity(gt=0)] = 0.02
    """Temperature below which it does not fall."""


# Model (Section 6.2.1): one state and n actions with values Q. Softmax choice and update are
#     Pr(a) = exp(Q(a) / T) / sum_a' exp(Q(a') / T)          (Eq 6.5)
#     Q(a) <- Q(a) + alpha (r - Q(a))                        (Eq 6.4)
# The reward r shrinks while a model habituates. The step size alpha is therefore constant: a mean
# over all rewards would give the first ones as much weight as the last.


class CatalogExploration(Exploration):
    """EXPLORECATALOG: an n-armed bandit with softmax choice (Algorithm 3, Eq 6.4 and 6.5)."""

    Constants: type[ExplorationConstants] = CatalogConstants

    def __init__(
        self, actions: Mapping[str, Sequence[FeatureForm]], constants: CatalogConstants
    ) -> None:
        self.values: dict[str, float] = {}
        super().__init__(actions, constants)
        self._settings = constants

    @property
    def temperature(self) -> float:
        """Temperature of the next choice."""
        settings = self._settings
        return max(settings.temperature * settings.decay ** len(self.steps), settings.coldest)

    def choose(self, rng: np.random.Generator) -> str:
        """Return the next action (see ``Exploration.choose``)."""
        names = self.actions
        values = np.array([self.values.get(name, 0.0) for name in names])
        # Differences to the maximum give the same probabilities, and no exponential overflows.
        weights = np.exp((values - values.max()) / self.temperature)
        return names[int(rng.choice(len(names), p=weights / weights.sum()))]

    def learn(self, step: ExplorationStep) -> None:
        """Update the action's value (see ``Exploration.learn``)."""
        value = self.values.get(step.action, 0.0)
        self.values[step.action] = value + self._settings.alpha * (step.reward - value)
