"""The schema document: a program whose resources are chosen by what is sensed (Section 5.3)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import Document, Name, Section, quantity
from cbdsl.documents.kind import Kind
from cbdsl.documents.policy import Curve, Provenance
from cbdsl.documents.program import Use

Probability = Annotated[float, quantity(ge=0, le=1)]


class AbstractAction(Section):
    """An abstract action a(phi, t_in, t_out): a controller without its resources."""

    potential: Name
    """The artificial potential phi."""
    in_: Annotated[str, Field(alias="in")]
    """Characteristic input type: that of the feedback."""
    out: str
    """Characteristic output type: that of the effector."""


class ChoiceQuestion(Section):
    """A question of the tree that chooses allocations."""

    if_: Annotated[str, Field(alias="if")]
    """Comparison of a feature with a quantity, such as ``place.y > 2 cm``."""
    then: ChoiceTree
    """Result if the condition holds."""
    else_: Annotated[ChoiceTree, Field(alias="else")]
    """Result if the condition does not hold."""


class RewardQuestion(Section):
    """A question of the tree that predicts reward."""

    if_: Annotated[str, Field(alias="if")]
    """Comparison of a feature with a quantity, such as ``place.x > 1.02 m``."""
    then: RewardTree
    """Result if the condition holds."""
    else_: Annotated[RewardTree, Field(alias="else")]
    """Result if the condition does not hold."""


ChoiceTree = ChoiceQuestion | tuple[Name, ...] | Name
"""A question, or allocations, the most promising one first."""

RewardTree = RewardQuestion | Probability
"""A question, or a probability of reward."""


class SchemaDocument(Document):
    """A policy over abstract actions, and how they are allocated with resources."""

    kind: Literal["schema"]
    """Says that this document is a schema."""
    program: Name
    """Program whose actions it allocates."""
    policy: Name
    """Learned policy that chooses the abstract actions, pi."""
    actions: dict[Name, AbstractAction] = {}
    """The declarative part of the program's controllers, by name (Eq 5.1)."""
    catalog: Name | None = None
    """Catalog whose probabilities of reward features can be, such as ``affords.reachtouch``."""
    features: Annotated[dict[Name, str], Field(min_length=1)]
    """Signals by which it allocates, with ``$name`` for parameters of the program."""
    look: dict[Name, Use] = {}
    """Programs that define features before anything is allocated, by the feature's name."""
    allocations: Annotated[dict[Name, dict[Name, str]], Field(min_length=1)]
    """Values of the program's parameters, and programs in the place of its members, by the name of
    the allocation (Eq 5.2)."""
    choose: ChoiceTree
    """The procedural policy psi (Eq 5.3): which allocation, by features."""
    otherwise: Annotated[tuple[Name, ...], Field(min_length=1)]
    """Allocations where a feature is undefined, the first one first."""
    reward: RewardTree | None = None
    """Probability of reward by features, Pr(reward | pi, f)."""
    least_reward: Probability = 0.5
    """Below this probability the schema is undefined, and moves nothing."""
    curve: Curve | None = None
    provenance: Provenance | None = None


ChoiceQuestion.model_rebuild()
RewardQuestion.model_rebuild()


SCHEMA = Kind(
    SchemaDocument,
    folder="knowledge/schemas",
    checker="cbdsl.checking.document:check_schema",
    unknown="CB641",
    references={"program": "program"},
    stand_ins={
        "program": "unknown",
        "policy": "unknown",
        "features": {"unknown": "unknown"},
        "allocations": {"unknown": {}},
        "choose": "unknown",
        "otherwise": ["unknown"],
    },
)
