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
    """Origin of a policy: everything that determines its content."""

    command: str
    """Command that repeats the learning."""
    program: Identity
    """Program of the episodes."""
    policies: dict[Name, Sha256] = {}
    """Learned policies within the program, by name, each with its models."""
    programs: dict[Name, Sha256] = {}
    """Other programs that allocations may use instead, by name, each with all that it uses."""
    shared: dict[Name, Sha256] = {}
    """Shared documents that the programs take up, by name."""
    earlier: Identity | None = None
    """Earlier knowledge of the same kind from which the learning went on."""
    parameters: dict[Name, str] = {}
    """Values of the parameters of the program."""
    actions: Annotated[tuple[str, ...], Field(min_length=1)]
    """Actions to choose from."""
    robot: Identity
    """Robot of the episodes."""
    origin: Identity | None = None
    """Robot that learned the policy, if another one did."""
    stage: Identity
    """Training context."""
    algorithm: Name
    """Learner, such as accommodate (Algorithm 1)."""
    constants: dict[Name, Count | Number | str]
    """Constants of the algorithm, in SI units."""
    seed: Count
    """Seed of all random numbers."""
    trial: Count = 0
    """Number of the trial among those with this seed."""
    episodes: PositiveCount
    """Number of episodes."""
    backend: str
    """Backend of the robot."""
    renderer: str
    """Renderer of the images."""
    versions: dict[str, str]
    """Versions of the packages that can change the outcome."""


class Curve(Section):
    """Learning curve: one entry per episode, in the order of exploration."""

    context: tuple[Name, ...]
    """Context of the stage."""
    reward: tuple[Count, ...]
    """Reward of the episode."""
    transitions: tuple[PositiveCount, ...]
    """Number of state transitions."""
    ticks: tuple[Count, ...]
    """Number of control ticks."""

    @model_validator(mode="after")
    def _is_even(self) -> Self:
        columns = (self.context, self.reward, self.transitions, self.ticks)
        if len({len(column) for column in columns}) > 1:
            raise ValueError("the parts of a learning curve have one entry per episode each")
        return self


class PolicyDocument(Document):
    """Policy that can replace the written policy of its program."""

    kind: Literal["policy"]
    """Kind of this document: a policy."""
    program: Name
    """Program of the policy."""
    predicates: tuple[str, ...]
    """Controllers and programs with the predicates of a state, in order."""
    policy: dict[str, str]
    """Action by state."""
    models: dict[str, Name] = {}
    """Internal models that replace the program's, such as ``head.uniform``."""
    values: dict[State, dict[str, Number]] = {}
    """Learned values: expected discounted reward by state and tried action."""
    # Counts show which states lie on the way to a reward, even if too few episodes were learned for
    # the action values to converge.
    transitions: dict[State, dict[str, dict[State, PositiveCount]]] = {}
    """Number of transitions by state, action and next state."""
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
