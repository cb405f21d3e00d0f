"""The relations document: names of the contacts of two objects, by impedance (Section 7.2)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import Document, Name, NonNegative, Section
from cbdsl.documents.kind import Kind
from cbdsl.documents.policy import Curve, Provenance


# A contact is named by its stiffness: an object on a table resists motion down, and one in a box
# resists motion sideways as well. Thresholds split each direction into free and resisted.
class RelationQuestion(Section):
    """Condition of the tree that names relations."""

    if_: Annotated[str, Field(alias="if")]
    """Comparison of the impedance in a direction with a quantity, such as ``dPz > 800 N/m``."""
    then: RelationTree
    """Result if the condition holds."""
    else_: Annotated[RelationTree, Field(alias="else")]
    """Result if the condition does not hold."""


RelationTree = RelationQuestion | Name
"""A question, or the name of a relation."""

Impedances = tuple[NonNegative, NonNegative, NonNegative, NonNegative, NonNegative, NonNegative]
"""Impedances in the directions dPx, dPy, dPz, N/m, and dRx, dRy, dRz, N m/rad."""


class RelationsDocument(Document):
    """Decision tree from the impedance of two objects in contact to the name of their relation."""

    kind: Literal["relations"]
    """Kind of this document: names of relations."""
    robot: Name
    """Robot of the tests."""
    program: Name
    """Program of the tests."""
    tree: RelationTree
    """Questions about the larger impedance of both senses of a direction."""
    samples: dict[Name, tuple[Impedances, ...]] = {}
    """Measured impedances that the tree was grown from, by name of the relation."""
    curve: Curve | None = None
    provenance: Provenance | None = None


RelationQuestion.model_rebuild()


RELATIONS = Kind(
    RelationsDocument,
    folder="knowledge/relations",
    checker="cbdsl.checking.knowledge.relations:examine_relations",
    unknown="CB680",
    references={"robot": "robot", "program": "program"},
    stand_ins={"robot": "unknown", "program": "unknown", "tree": "unknown"},
)
