"""The meta-catalog document: which things go on which, or into which (Sections 7.1.3 and 7.3)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cbdsl.documents.catalog import AffordanceSection, CatalogProvenance, StepColumns
from cbdsl.documents.document import Count, Document, Name, PositiveCount, Section, quantity
from cbdsl.documents.kind import Kind
from cbdsl.types.direction import Direction

Relation = Literal["on", "in"]
Stiffness = Annotated[float, quantity("stiffness", "torsional stiffness", ge=0)]


# A meta-catalog is a graph. Its nodes are objects, each with a catalog of its own affordances. A
# directed edge leads from the object that is brought to the one below it or around it. The edge
# holds the affordance of bringing them together, and the measured impedance of their contact.
class KnownThing(Section):
    """Object with its channel and its catalog."""

    feature: str
    """Channel of vision that identifies the object, or the upper part of a stack."""
    catalog: Name | None = None
    """Catalog of the affordances of the object."""
    meta_catalog: Name | None = None
    """Meta-catalog with the pair that the object is, if it is a stack; both have the same name."""


class ImpedanceSection(Section):
    """Impedance of two objects in contact, from tests along and about the axes (Section 7.2)."""

    profiles: PositiveCount
    """Number of profiles: trials in which all directions were tested in both senses."""
    tracked: dict[Direction, Count] = {}
    """Number of profiles in which the load was tracked, by direction (Figure 7.13)."""
    mean: dict[Direction, Stiffness] = {}
    """Geometric mean over the profiles of the larger impedance of both senses, N/m or N m/rad."""
    relation: Name | None = None
    """Most frequent name of the relation."""
    names: dict[Name, PositiveCount] = {}
    """Number of profiles by the name that the tree of ``relations`` gives them."""

    @model_validator(mode="after")
    def _is_of_its_profiles(self) -> Self:
        # Each profile tracks a direction at most once, and gets at most one name.
        most = max(self.tracked.values(), default=0)
        if most > self.profiles or sum(self.names.values()) > self.profiles:
            raise ValueError(f"{self.profiles} profiles have no more than so many loads and names")
        return self


class PairSection(AffordanceSection):
    """Knowledge of one object brought to another: an edge of the graph."""

    upper: Name
    """Object that is brought."""
    lower: Name
    """Object that it is brought to, or on top of which."""
    relation: Relation = "on"
    """Intended relation: on the lower object, or in it."""
    impedance: ImpedanceSection | None = None
    """Impedance of the contact, if the program tests it."""


class MetaCatalogDocument(Document):
    """Catalogs of objects and affordances of their pairs, as explored by a robot."""

    kind: Literal["meta_catalog"]
    """Kind of this document: a meta-catalog."""
    robot: Name
    """Robot of the exploration."""
    things: Annotated[dict[Name, KnownThing], Field(min_length=1)]
    """Nodes of the graph, by name."""
    pairs: dict[Name, PairSection] = {}
    """Edges of the graph, by name."""
    over: tuple[Name, ...] = ()
    """Meta-catalogs joined by this one."""
    relations: Name | None = None
    """Relations whose tree names the measured contacts."""
    steps: StepColumns | None = None
    """Actions in order, by name of the pair."""
    provenance: CatalogProvenance | None = None


META_CATALOG = Kind(
    MetaCatalogDocument,
    folder="knowledge/meta_catalogs",
    checker="cbdsl.checking.knowledge.meta_catalog:examine_meta_catalog",
    unknown="CB660",
    references={"robot": "robot", "relations": "relations"},
    stand_ins={"robot": "unknown", "things": {}},
)
