"""Catalog document: affordances of an object, with their uncertainty (Section 6.2)."""

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


# An affordance model is the density Pr(f | reward, a) of the features f at the start of an action a
# that is rewarded (Eq 6.1). It is a Gaussian, so that its mean and covariance and the number of
# samples determine it. The covariance alone does not show how certain a model is: few samples may
# lie close together by chance.
class SampleModel(Section):
    """Multivariate Gaussian of features, as mean and covariance of its samples."""

    count: PositiveCount
    """Number of samples."""
    mean: Annotated[tuple[Number, ...], Field(min_length=1)]
    """Mean of each component, in SI units."""
    covariance: Annotated[tuple[tuple[Number, ...], ...], Field(min_length=1)]
    """Covariance of the components, by rows, in SI units."""

    @model_validator(mode="after")
    def _is_square(self) -> Self:
        # Only the shape is checked here. Symmetry and definiteness need arrays, and are checked
        # together with the signals of the robot.
        size = len(self.mean)
        if len(self.covariance) != size or any(len(row) != size for row in self.covariance):
            raise ValueError(f"a mean of {size} components has a covariance of {size} by {size}")
        return self


class FeatureSection(Section):
    """Signal of an affordance's models."""

    signal: str
    """Resource that gives the signal when the action begins to act on the object."""
    unit: str
    """SI unit of the components."""
    components: PositiveCount
    """Number of components."""


class Habituation(Section):
    """Certainty of a model."""

    variance: NonNegative
    """Variance of the model with its prior, as a multiple of the prior's variance."""
    change: NonNegative
    """Change of the variance at the last reward, relative to the largest change of the catalog."""
    habituated: bool
    """True if the change is so small that the action teaches nothing new."""


class AffordanceSection(Section):
    """Knowledge of one action."""

    program: Name
    """Program of the action."""
    with_: Annotated[dict[Name, str], Field(alias="with")] = {}
    """Values of the parameters of the program."""
    tried: Count
    """Number of trials."""
    rewarded: Count
    """Number of rewarded trials."""
    interval: tuple[Probability, Probability] | None = None
    """95 % interval of the probability of reward, Pr(reward | a)."""
    features: dict[Name, FeatureSection] = {}
    """Signals of the models, in the order of their components."""
    with_reward: SampleModel | None = None
    """Features with reward, Pr(f | reward, a) (Eq 6.1)."""
    without_reward: SampleModel | None = None
    """Features without reward."""
    habituation: Habituation | None = None
    value: Number = 0.0
    """Expected reward of the next trial (Eq 6.4)."""
    failed: str = ""
    """Reason why the action cannot run."""

    @model_validator(mode="after")
    def _is_rewarded_at_most_always(self) -> Self:
        if self.rewarded > self.tried:
            raise ValueError(f"it was rewarded {self.rewarded} times, and tried {self.tried} times")
        return self


class StepColumns(Section):
    """Actions in order, one entry each."""

    action: tuple[Name, ...]
    """Chosen action; ``noop`` for none."""
    rewarded: tuple[bool, ...]
    """True if the action was rewarded."""
    change: tuple[NonNegative, ...]
    """Change of the variance of the action's model, as a multiple of the prior's variance."""
    reward: tuple[Number, ...]
    """Reward by Eq 6.2, relative to the largest change up to this step."""

    @model_validator(mode="after")
    def _is_even(self) -> Self:
        columns = (self.action, self.rewarded, self.change, self.reward)
        if len({len(column) for column in columns}) > 1:
            raise ValueError("the parts of a catalog's steps have one entry per action each")
        return self


class JoinedActions(Section):
    """Actions added to an exploration after it began."""

    after: Count
    """Number of actions before the addition."""
    programs: tuple[Name, ...]
    """Added actions; none if only the stage changed."""
    stage: Identity
    """Stage from then on."""


class CatalogProvenance(Section):
    """Origin of a catalog: everything that determines its content."""

    command: str
    """Command that repeats the exploration."""
    programs: dict[Name, Identity]
    """Program of each action."""
    policies: dict[Name, Sha256] = {}
    """Learned policies within these programs, by name."""
    shared: dict[Name, Sha256] = {}
    """Shared documents that these programs take up, by name."""
    relations: Identity | None = None
    """Relations that named the measured contacts."""
    robot: Identity
    """Robot of the exploration."""
    stage: Identity
    """Stage of the exploration."""
    algorithm: Name
    """Algorithm that chose the actions, such as explore_catalog (Algorithm 3)."""
    constants: dict[Name, Count | Number | str]
    """Constants of the algorithm, in SI units."""
    seed: Count
    """Seed of all random numbers."""
    trial: Count = 0
    """Number of the trial among those with this seed."""
    actions: Count
    """Number of actions taken."""
    joined: tuple[JoinedActions, ...] = ()
    """Actions added later, in their order."""
    backend: str
    """Backend of the robot."""
    renderer: str
    """Renderer of the images."""
    versions: dict[str, str]
    """Versions of the packages that can change the outcome."""


class CatalogDocument(Document):
    """Affordances of a visual feature, as explored by a robot."""

    kind: Literal["catalog"]
    """Kind of this document: a catalog."""
    robot: Name
    """Robot of the exploration."""
    feature: str
    """Channel of vision that identifies the object."""
    affordances: Annotated[dict[Name, AffordanceSection], Field(min_length=1)]
    """Affordances by name of the action."""
    over: tuple[Name, ...] = ()
    """Catalogs joined by this one."""
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
