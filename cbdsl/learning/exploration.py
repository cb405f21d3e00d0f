"""Exploration of affordances: which action to take next, and what is known of each (Chapter 6)."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.document import Count, Section, quantity
from cbdsl.numeric.affordance import AffordanceModel, Measure, deviation_of

Floats = NDArray[np.float64]

#: The action that costs nothing and tells nothing.
NOOP = "noop"


class ExplorationConstants(Section):
    """Constants that all explorations have (Sections 6.1 and 6.2)."""

    alpha: Annotated[float, quantity(gt=0, le=1)] = 0.3
    """ExplorationStep size of the value's update."""
    cost: Annotated[float, quantity(ge=0, lt=1)] = 0.05
    """Cost rho of every action but noop."""
    prior: Annotated[float, quantity(gt=0)] = 1.0
    """As how many samples the prior of a model counts."""
    units: Literal["workspace", "si"] = "workspace"
    """Deviations of the prior: 3 cm, 0.1 rad, 1 l and so on, or 1 in SI."""
    measure: Measure = "sum"
    """Variance of a covariance: the sum of all its elements, its trace, or the d-th root of its
    determinant."""
    habituated: Annotated[float, quantity(gt=0, le=1)] = 0.1
    """Below this change of its variance, relative to the largest so far, a model is habituated."""
    least: Count = 3
    """Times that each action is taken at least before an exploration is over."""
    longest: Annotated[float, quantity("time", gt=0, le=3600)] = 60.0
    """Time after which an action that is not over has failed."""


class FeatureForm(NamedTuple):
    """A feature as a model sees it.

    Attributes:
        name: in the catalog.
        unit: of its components.
        size: how many it has.
    """

    name: str
    unit: str
    size: int


class ActionOutcome(NamedTuple):
    """Outcome of one action.

    Attributes:
        action: its name.
        rewarded: whether it was rewarded by Eq 4.4.
        features: components of the features that were defined at its activation, in SI, by name.
        opened: actions that it made possible, such as the inspection of a mark that was seen.
        ahead: features of each known action that were defined when it was over.
        ending: how it ended, as a sentence.
        failed: whether it could not be run.
        sim_seconds: how long it took.
    """

    action: str
    rewarded: bool = False
    features: Mapping[str, tuple[float, ...]] = {}
    opened: tuple[str, ...] = ()
    ahead: Mapping[str, Mapping[str, tuple[float, ...]]] = {}
    ending: str = ""
    failed: bool = False
    sim_seconds: float = 0.0


class ExplorationStep(NamedTuple):
    """Evaluation of an outcome by an exploration.

    Attributes:
        action: that was taken.
        rewarded: whether it was rewarded.
        change: of its model's variance, in units of the prior's.
        reward: by Eq 6.2, the change relative to the largest until then, minus the cost.
    """

    action: str
    rewarded: bool
    change: float
    reward: float


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
    _before: list[Mapping[str, tuple[float, ...]]] = field(default_factory=list)

    def note(self, outcome: ActionOutcome, constants: ExplorationConstants) -> float:
        """Take in an outcome; returns how much it changed the variance of the model."""
        self.tried += 1
        self.successes += outcome.rewarded
        self.failed |= outcome.failed
        if self.model is None and outcome.rewarded and outcome.features:
            self._begin(outcome.features, constants)
        if self.model is None:
            self._before.append(outcome.features)
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
        for features in self._before:
            model = model.updated(self.vector(features), rewarded=False)
        self.model = model

    def distance(self) -> float:
        """Mahalanobis distance of what is seen ahead from the features with reward; 0 unknown."""
        seen = self.vector(self.ahead) if self.model is not None and self.ahead else None
        return 0.0 if seen is None or self.model is None else self.model.distance(seen)

    def vector(self, features: Mapping[str, tuple[float, ...]]) -> Floats | None:
        """Components of the model's features, ``None`` where one is undefined."""
        if not all(name in features for name in self.features):
            return None
        return np.array([value for name in self.features for value in features[name]])


class Exploration(ABC):
    """Chooses actions by what they are expected to tell, and models what they afford.

    All it knows follows from the outcomes that it noted, in their order.

    Args:
        actions: forms of their features, by name; ``noop`` is added.
        constants: of the algorithm.

    Attributes:
        affordances: what is known of each action but noop, by name.
        steps: what was done so far.
        constants: of the algorithm.
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
        """The next action."""

    @abstractmethod
    def learn(self, step: ExplorationStep) -> None:
        """Take in the reward of a step, whose models are up to date."""

    def add(self, actions: Mapping[str, Sequence[FeatureForm]]) -> None:
        """Add actions that were not known, such as those that another made possible."""
        for name, forms in actions.items():
            self.affordances.setdefault(name, Affordance(tuple(forms)))

    def note(self, outcome: ActionOutcome) -> ExplorationStep:
        """Take in what became of an action (Algorithm 3, lines 10 to 21)."""
        if outcome.action == NOOP:
            step = ExplorationStep(NOOP, False, 0.0, 0.0)
        else:
            change = self.affordances[outcome.action].note(outcome, self.constants)
            change = change if outcome.rewarded else 0.0
            self._largest = max(self._largest, change)
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
        """The last change of a model's variance relative to the largest so far, or ``None``."""
        change = self.affordances[name].change
        return None if change is None or not self._largest else change / self._largest

    def is_habituated(self, name: str) -> bool:
        """Whether an action was tried often enough, and its model changes no more."""
        affordance = self.affordances[name]
        change = self.change_of(name)
        calm = change is None or change < self.constants.habituated
        return affordance.failed or (affordance.tried >= self.constants.least and calm)

    @property
    def is_over(self) -> bool:
        """Whether all models have habituated (Algorithm 3, line 22)."""
        return all(map(self.is_habituated, self.affordances))


def by_largest_of_all(steps: Iterable[ExplorationStep], cost: float) -> list[float]:
    """Rewards as the source has them: changes relative to the largest of the whole trial.

    That is known only at its end; no learner can use it.
    """
    steps = list(steps)
    largest = max((step.change for step in steps), default=0.0) or 1.0
    return [0.0 if step.action == NOOP else step.change / largest - cost for step in steps]


class CatalogConstants(ExplorationConstants):
    """Constants of EXPLORECATALOG (Algorithm 3)."""

    temperature: Annotated[float, quantity(gt=0)] = 0.3
    """Temperature tau of the first choice; the source has 1."""
    decay: Annotated[float, quantity(gt=0, le=1)] = 0.96
    """Factor of the temperature from one choice to the next; the source has 0.99."""
    coldest: Annotated[float, quantity(gt=0)] = 0.02
    """Temperature below which it does not fall."""


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
        """See ``Exploration.choose``."""
        names = self.actions
        values = np.array([self.values.get(name, 0.0) for name in names])
        weights = np.exp((values - values.max()) / self.temperature)
        return names[int(rng.choice(len(names), p=weights / weights.sum()))]

    def learn(self, step: ExplorationStep) -> None:
        """See ``Exploration.learn``."""
        value = self.values.get(step.action, 0.0)
        self.values[step.action] = value + self._settings.alpha * (step.reward - value)


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


class ModelExploration(Exploration):
    """A model-exploration program: Q-learning over the states of models (Eq 6.6)."""

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
        """One letter a model: X unknown, - undefined, 0 changing, 1 habituated (Eq 6.6)."""
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
        """Reward to expect of each action in the state now."""
        return self._row(self.state)

    def _row(self, state: str) -> dict[str, float]:
        """Values in a state: of what was not tried in it, what a model promises."""
        promises = {
            name: self._settings.promise if letter in "X0" else 0.0
            for name, letter in zip(self.affordances, state, strict=False)
        }
        return {NOOP: 0.0, **promises, **self.table.get(state, {})}

    def choose(self, rng: np.random.Generator) -> str:
        """See ``Exploration.choose``; of equal values each is as likely."""
        names, self._last = self.actions, self.state
        if rng.random() < self._settings.epsilon:
            return names[int(rng.integers(len(names)))]
        own = self._row(self._last)
        best = max(own[name] for name in names)
        equal = [name for name in names if math.isclose(own[name], best, abs_tol=1e-12)]
        return equal[int(rng.integers(len(equal)))]

    def note(self, outcome: ActionOutcome) -> ExplorationStep:
        """See ``Exploration.note``."""
        self._last = self.state
        return super().note(outcome)

    def learn(self, step: ExplorationStep) -> None:
        """See ``Exploration.learn``."""
        value = self._row(self._last)[step.action]
        ahead = self._row(self.state)
        best = max(ahead[name] for name in self.actions)
        target = step.reward + self._settings.gamma * best
        row = self.table.setdefault(self._last, {})
        row[step.action] = value + self._settings.alpha * (target - value)


#: Explorations by the name of their algorithm.
EXPLORATIONS: Mapping[str, type[Any]] = {
    "explore_catalog": CatalogExploration,
    "explore_models": ModelExploration,
}
