"""The meta-catalog document: which things go on which, or into which (Sections 7.1.3 and 7.3)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.catalog import AffordanceSection, CatalogProvenance, StepColumns
from cbdsl.documents.document import Document, Name, Section
from cbdsl.documents.kind import Kind

Relation = Literal["on", "in"]


class KnownThing(Section):
    """Object with its channel and its catalog."""

    feature: str
    """Channel of vision that identifies the object."""
    catalog: Name | None = None
    """Catalog of the affordances of the object."""


class PairSection(AffordanceSection):
    """Knowledge of one object brought to another: an edge of the graph."""

    upper: Name
    """Object that is brought."""
    lower: Name
    """Object that it is brought to, or on top of which."""
    relation: Relation = "on"
    """Intended relation: on the lower object, or in it."""


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
    steps: StepColumns | None = None
    """Actions in order, by name of the pair."""
    provenance: CatalogProvenance | None = None


META_CATALOG = Kind(
    MetaCatalogDocument,
    folder="knowledge/meta_catalogs",
    checker="cbdsl.checking.knowledge.meta_catalog:examine_meta_catalog",
    unknown="CB660",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "things": {}},
)
