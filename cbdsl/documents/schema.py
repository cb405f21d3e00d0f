"""Schema document: a program with resources chosen by features (Section 5.3)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cbdsl.documents.document import Document, Name, Number, Section, quantity
from cbdsl.documents.kind import Kind
from cbdsl.documents.policy import Curve, Provenance
from cbdsl.documents.program import Use

Probability = Annotated[float, quantity(ge=0, le=1)]


# A schema splits a program in two (Section 5.3). The declarative part is a policy pi over abstract
# actions a(phi, t_in, t_out), which name types instead of resources. The procedural part psi
# chooses resources of these types by the features f of the context (Eq 5.3). Here, psi is a
# decision tree that chooses one allocation for all actions of the program. A second tree predicts
# Pr(reward | pi, f). If it is too low, the schema is undefined for the program that uses it.
class AbstractAction(Section):
    """Abstract action a(phi, t_in, t_out): a controller without its resources."""

    potential: Name
    """Artificial potential phi."""
    in_: Annotated[str, Field(alias="in")]
    """Characteristic input type: type of the feedback."""
    out: str
    """Characteristic output type: type of the effector."""


class ChoiceQuestion(Section):
    """Condition of the tree that chooses allocations."""

    if_: Annotated[str, Field(alias="if")]
    """Comparison of a feature with a quantity, such as ``place.y > 2 cm``."""
    then: ChoiceTree
    """Result if the condition holds."""
    else_: Annotated[ChoiceTree, Field(alias="else")]
    """Result if the condition does not hold."""


class RewardQuestion(Section):
    """Condition of the tree that predicts reward."""

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
    """Policy over abstract actions, with the allocation of their resources."""

    kind: Literal["schema"]
    """Kind of this document: a schema."""
    program: Name
    """Program of the actions."""
    policy: Name
    """Learned policy pi that chooses the abstract actions."""
    actions: dict[Name, AbstractAction] = {}
    """Declarative part of the program's controllers, by name (Eq 5.1)."""
    models: dict[str, Name] = {}
    """Internal models of this robot that replace the program's, such as ``hand.uniform``, if
    another robot learned the policy."""
    catalog: Name | None = None
    """Catalog with probabilities of reward for use as features, such as ``affords.reachtouch``."""
    features: Annotated[dict[Name, str], Field(min_length=1)]
    """Signals that determine the allocation, with ``$name`` for parameters of the program."""
    look: dict[Name, Use] = {}
    """Programs that define features before the allocation, by name of the feature."""
    allocations: Annotated[dict[Name, dict[Name, str]], Field(min_length=1)]
    """Values of the program's parameters, and programs that replace its members, by name of the
    allocation (Eq 5.2)."""
    choose: ChoiceTree
    """Procedural policy psi (Eq 5.3): allocation by features."""
    otherwise: Annotated[tuple[Name, ...], Field(min_length=1)]
    """Allocations for an undefined feature, in order of preference."""
    reward: RewardTree | None = None
    """Probability of reward by features, Pr(reward | pi, f)."""
    tried: dict[str, tuple[Number, Number]] = {}
    """Least and largest value of each component of the features in the learned contexts, in SI.
    Elsewhere the probability of reward is unknown, and the schema acts."""
    least_reward: Probability = 0.5
    """Probability of reward below which the schema is undefined and moves nothing."""
    curve: Curve | None = None
    provenance: Provenance | None = None

    @model_validator(mode="after")
    def _has_ordered_ranges(self) -> Self:
        for name, (low, high) in self.tried.items():
            if low > high:
                raise ValueError(f"tried: {name} is from {low:g} to {high:g}; put the least first")
        return self


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
