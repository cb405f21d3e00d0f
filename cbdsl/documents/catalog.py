"""The catalog document: what an object affords, and how sure that is (Section 6.2)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cbdsl.documents.document import (
    Count,
    Document,
    Name,
    NonNegative,
    Number,
    PositiveCount,
    Section,
    quantity,
)
from cbdsl.documents.kind import Kind
from cbdsl.documents.policy import Identity, Sha256

Probability = Annotated[float, quantity(ge=0, le=1)]


class SampleModel(Section):
    """A multivariate Gaussian of features, as mean and covariance of its samples."""

    count: PositiveCount
    """How many samples."""
    mean: Annotated[tuple[Number, ...], Field(min_length=1)]
    """Mean of each component, in SI."""
    covariance: Annotated[tuple[tuple[Number, ...], ...], Field(min_length=1)]
    """Covariance of the components, row by row, in SI."""

    @model_validator(mode="after")
    def _is_square(self) -> Self:
        size = len(self.mean)
        if len(self.covariance) != size or any(len(row) != size for row in self.covariance):
            raise ValueError(f"a mean of {size} components has a covariance of {size} by {size}")
        return self


class FeatureSection(Section):
    """A signal that the model of an affordance is over."""

    signal: str
    """Resource that it is read from when the action begins to act on it."""
    unit: str
    """Unit of its components, in SI."""
    components: PositiveCount
    """How many numbers it has."""


class Habituation(Section):
    """How sure the model is by now."""

    variance: NonNegative
    """Variance of the model with its prior, in units of the prior's."""
    change: NonNegative
    """Change of it when the action was last rewarded, relative to the largest of the catalog."""
    habituated: bool
    """True if the change is so small that the action teaches nothing new."""


class AffordanceSection(Section):
    """Knowledge of one action."""

    program: Name
    """Program that runs."""
    with_: Annotated[dict[Name, str], Field(alias="with")] = {}
    """Values of its parameters."""
    tried: Count
    """How often it was taken."""
    rewarded: Count
    """How often it was rewarded."""
    interval: tuple[Probability, Probability] | None = None
    """Interval of 95 % of the probability of reward, Pr(reward | a)."""
    features: dict[Name, FeatureSection] = {}
    """Signals that the models are over, in the order of their components."""
    with_reward: SampleModel | None = None
    """Features with reward, Pr(f | reward, a) (Eq 6.1)."""
    without_reward: SampleModel | None = None
    """Features without reward."""
    habituation: Habituation | None = None
    value: Number = 0.0
    """Reward to expect of taking it again (Eq 6.4)."""
    failed: str = ""
    """Reason if it cannot run."""

    @model_validator(mode="after")
    def _is_rewarded_at_most_always(self) -> Self:
        if self.rewarded > self.tried:
            raise ValueError(f"it was rewarded {self.rewarded} times, and tried {self.tried} times")
        return self


class StepColumns(Section):
    """The actions in turn, one entry each."""

    action: tuple[Name, ...]
    """Action that was taken; noop is none."""
    rewarded: tuple[bool, ...]
    """Whether it was rewarded."""
    change: tuple[NonNegative, ...]
    """Change of the variance of its model, in units of the prior's."""
    reward: tuple[Number, ...]
    """Reward by Eq 6.2, relative to the largest change so far."""

    @model_validator(mode="after")
    def _is_even(self) -> Self:
        columns = (self.action, self.rewarded, self.change, self.reward)
        if len({len(column) for column in columns}) > 1:
            raise ValueError("the parts of a catalog's steps have one entry per action each")
        return self


class JoinedActions(Section):
    """Actions that joined an exploration when it had begun."""

    after: Count
    """Number of actions at that time."""
    programs: tuple[Name, ...]
    """Actions that joined, none where the world alone changed."""
    stage: Identity
    """World that it went on in."""


class CatalogProvenance(Section):
    """Everything that the catalog depends on."""

    command: str
    """Command that explores it again."""
    programs: dict[Name, Identity]
    """Program of each action."""
    policies: dict[Name, Sha256] = {}
    """Learned policies that ran inside of them, by name."""
    robot: Identity
    """Robot that acted."""
    stage: Identity
    """World that it acted in."""
    algorithm: Name
    """How actions were chosen, such as explore_catalog (Algorithm 3)."""
    constants: dict[Name, Count | Number | str]
    """Constants of the algorithm, in SI."""
    seed: Count
    """Seed of all chance."""
    trial: Count = 0
    """Which of several trials with this seed."""
    actions: Count
    """How many actions were taken."""
    joined: tuple[JoinedActions, ...] = ()
    """Actions that joined later, in their order."""
    backend: str
    """Backend that embodied the robot."""
    renderer: str
    """Renderer that made the images."""
    versions: dict[str, str]
    """Of the packages that the outcome depends on."""


class CatalogDocument(Document):
    """The affordances that belong to a visual feature, as a robot has explored them."""

    kind: Literal["catalog"]
    """Says that this document is a catalog."""
    robot: Name
    """Robot that explored it."""
    feature: str
    """Channel of vision by which the object is known."""
    affordances: Annotated[dict[Name, AffordanceSection], Field(min_length=1)]
    """Affordances by name of the action."""
    over: tuple[Name, ...] = ()
    """Catalogs that this one joins."""
    steps: StepColumns | None = None
    provenance: CatalogProvenance | None = None


CATALOG = Kind(
    CatalogDocument,
    folder="knowledge/catalogs",
    checker="cbdsl.checking.knowledge.catalog:examine_catalog",
    unknown="CB650",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "feature": "unknown", "affordances": {}},
)
