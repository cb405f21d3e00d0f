"""The policy document: which action follows which state, apart from the program it serves."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cbdsl.documents.document import Count, Document, Name, Number, PositiveCount, Section
from cbdsl.documents.kind import Kind
from cbdsl.types.state import STATE

State = Annotated[str, Field(pattern=STATE)]
"""Predicates, one letter each."""

Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
"""SHA-256 in hexadecimal."""


class Identity(Section):
    """Name and digest of a document."""

    name: Name
    """Name of the document."""
    sha256: Sha256
    """Digest of its content, without comments, layout and irrelevant keys."""


class Provenance(Section):
    """Origin of a policy: everything that its outcome depends on."""

    command: str
    """Command that learns it again."""
    program: Identity
    """Program that was run."""
    policies: dict[Name, Sha256] = {}
    """Learned policies that ran inside of it, by name, each with the models that belong to it."""
    parameters: dict[Name, str] = {}
    """Values of its parameters."""
    actions: Annotated[tuple[str, ...], Field(min_length=1)]
    """Actions that could be chosen."""
    robot: Identity
    """Robot that ran it."""
    stage: Identity
    """Training context."""
    algorithm: Name
    """Learner, such as accommodate (Algorithm 1)."""
    constants: dict[Name, Count | Number | str]
    """Constants of the algorithm, in SI."""
    seed: Count
    """Seed of all chance."""
    trial: Count = 0
    """Which of several trials with this seed."""
    episodes: PositiveCount
    """How many episodes were learned from."""
    backend: str
    """Backend that embodied the robot."""
    renderer: str
    """Renderer that made the images."""
    versions: dict[str, str]
    """Of the packages that the outcome depends on."""


class Curve(Section):
    """The learning curve: one entry per episode, while it explored."""

    context: tuple[Name, ...]
    """Which of the stage's contexts it was."""
    reward: tuple[Count, ...]
    """Reward that was earned."""
    transitions: tuple[PositiveCount, ...]
    """Transitions that it took."""
    ticks: tuple[Count, ...]
    """Control ticks that it took."""

    @model_validator(mode="after")
    def _is_even(self) -> Self:
        columns = (self.context, self.reward, self.transitions, self.ticks)
        if len({len(column) for column in columns}) > 1:
            raise ValueError("the parts of a learning curve have one entry per episode each")
        return self


class PolicyDocument(Document):
    """A policy that can stand in for the one written in its program."""

    kind: Literal["policy"]
    """Says that this document is a policy."""
    program: Name
    """Program that it serves."""
    predicates: tuple[str, ...]
    """The controllers and programs whose predicates make up a state, in order."""
    policy: dict[str, str]
    """Action by state."""
    models: dict[str, Name] = {}
    """Internal models that take the place of the program's, such as ``head.uniform``."""
    values: dict[State, dict[str, Number]] = {}
    """Learned values: expected discounted reward by state and action that was tried in it."""
    transitions: dict[State, dict[str, dict[State, PositiveCount]]] = {}
    """How often a state was followed by another, by state, action and next state."""
    curve: Curve | None = None
    provenance: Provenance | None = None


POLICY = Kind(
    PolicyDocument,
    folder="knowledge/policies",
    checker="cbdsl.checking.policy:examine_policy",
    unknown="CB625",
    references={"program": "program"},
    stand_ins={"program": "unknown", "predicates": [], "policy": {}},
)
