"""Affordance: an action of an exploration with its learned model (Section 6.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cbdsl.learning.catalogs.action_outcome import ActionOutcome, FeatureForm
from cbdsl.learning.catalogs.exploration_constants import ExplorationConstants
from cbdsl.numeric.affordance_model import AffordanceModel, deviation_of
from cbdsl.numeric.arrays import Floats


@dataclass
class Affordance:
    """Action of an exploration, and its model.

    The first reward selects the features of the model: those defined at that time.

    Attributes:
        forms: Forms of the possible features.
        features: Names of the model's features; empty before the first reward.
        model: Model of these features; ``None`` before the first reward.
        tried, successes: Numbers of trials and of rewarded trials.
        change: Change of the variance at the last reward; ``None`` before the first one.
        failed: True if the action can no longer be run.
        ahead: Most recently observed features, before the action is taken again.
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
        """Learn from an outcome and return the change of the model's variance."""
        self.tried += 1
        self.successes += outcome.rewarded
        self.failed |= outcome.failed
        if self.model is None and outcome.rewarded and outcome.features:
            self._begin(outcome.features, constants)
        if self.model is None:
            self._before.append(outcome)
            return 0.0
        before = self.model
        self.model = before.updated(self.vector(outcome.features), rewarded=outcome.rewarded)
        change = before.change_to(self.model, constants.measure)
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
        # Earlier trials were unrewarded, or lacked features. They count as trials of the new model,
        # too.
        for outcome in self._before:
            model = model.updated(self.vector(outcome.features), rewarded=outcome.rewarded)
        self.model = model

    def distance(self) -> float:
        """Return the Mahalanobis distance from the features ahead to the rewarded ones, or 0."""
        seen = self.vector(self.ahead) if self.model is not None and self.ahead else None
        return 0.0 if seen is None or self.model is None else self.model.distance(seen)

    def reward_probability(self) -> float:
        """Return Pr(reward | f, a) by the features ahead, or Pr(reward | a) without them."""
        if self.model is None:
            return (self.successes + 1) / (self.tried + 2)
        seen = self.vector(self.ahead)
        return self.model.reward_probability if seen is None else self.model.reward_given(seen)

    def vector(self, features: Mapping[str, tuple[float, ...]]) -> Floats | None:
        """Return the components of the model's features, or ``None`` if one is undefined."""
        if not all(name in features for name in self.features):
            return None
        return np.array([value for name in self.features for value in features[name]])
