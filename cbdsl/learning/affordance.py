"""Affordance: an action of an exploration, and what is known of it (Section 6.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cbdsl.learning.action_outcome import ActionOutcome, FeatureForm
from cbdsl.learning.exploration_constants import ExplorationConstants
from cbdsl.numeric.affordance import AffordanceModel, deviation_of

Floats = NDArray[np.float64]


@dataclass
class Affordance:
    """An action of an exploration, and its model.

    Which features its model is over is decided by the first reward: those that were defined then.

    Attributes:
        forms: the features that it may have.
        features: those that its model has, by name; empty before the first reward.
        model: of them; ``None`` before.
        tried, successes: counts.
        change: of the variance when it was last rewarded; ``None`` before.
        failed: whether it can no longer be run.
        ahead: its features as they were seen last, before it is taken again.
    """

    forms: tuple[FeatureForm, ...]
    features: tuple[str, ...] = ()
    model: AffordanceModel | None = None
    tried: int = 0
    successes: int = 0
    change: float | None = None
    failed: bool = False
    ahead: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    _before: list[ActionOutcome] = field(default_factory=list)

    def note(self, outcome: ActionOutcome, constants: ExplorationConstants) -> float:
        """Take in an outcome; returns how much it changed the variance of the model."""
        self.tried += 1
        self.successes += outcome.rewarded
        self.failed |= outcome.failed
        if self.model is None and outcome.rewarded and outcome.features:
            self._begin(outcome.features, constants)
        if self.model is None:
            self._before.append(outcome)
            return 0.0
        before = self.model.variance(constants.measure)
        self.model = self.model.updated(self.vector(outcome.features), rewarded=outcome.rewarded)
        after = self.model.variance(constants.measure)
        change = abs(after - before)
        if outcome.rewarded and self.vector(outcome.features) is not None:
            self.change = change
        return change

    def _begin(
        self, defined: Mapping[str, tuple[float, ...]], constants: ExplorationConstants
    ) -> None:
        chosen = [form for form in self.forms if form.name in defined]
        self.features = tuple(form.name for form in chosen)
        deviations = [
            deviation_of(form.unit) if constants.units == "workspace" else 1.0
            for form in chosen
            for _ in range(form.size)
        ]
        model = AffordanceModel.fresh(np.array(deviations), constants.prior)
        for outcome in self._before:
            model = model.updated(self.vector(outcome.features), rewarded=outcome.rewarded)
        self.model = model

    def distance(self) -> float:
        """Mahalanobis distance of what is seen ahead from the features with reward; 0 unknown."""
        seen = self.vector(self.ahead) if self.model is not None and self.ahead else None
        return 0.0 if seen is None or self.model is None else self.model.distance(seen)

    def reward_probability(self) -> float:
        """Pr(reward | f, a) by what is seen ahead; Pr(reward | a) where that tells nothing."""
        if self.model is None:
            return (self.successes + 1) / (self.tried + 2)
        seen = self.vector(self.ahead)
        return self.model.reward_probability if seen is None else self.model.reward_given(seen)

    def vector(self, features: Mapping[str, tuple[float, ...]]) -> Floats | None:
        """Components of the model's features, ``None`` where one is undefined."""
        if not all(name in features for name in self.features):
            return None
        return np.array([value for name in self.features for value in features[name]])
