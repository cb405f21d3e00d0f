"""The meta-catalog document: which things go on which, or into which (Sections 7.1.3 and 7.3)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.catalog import AffordanceSection, CatalogProvenance, StepColumns
from cbdsl.documents.document import Document, Name, Section
from cbdsl.documents.kind import Kind

Relation = Literal["on", "in"]


class KnownThing(Section):
    """A thing, by how it is known."""

    feature: str
    """Channel of vision by which it is known."""
    catalog: Name | None = None
    """Catalog of its own affordances."""


class PairSection(AffordanceSection):
    """Knowledge of two things that were brought together: an edge of the graph."""

    upper: Name
    """Thing that is brought."""
    lower: Name
    """Thing that it is brought to, or the top thing on it."""
    relation: Relation = "on"
    """Whether it is to stay on that, or in it."""


class MetaCatalogDocument(Document):
    """Catalogs of things, and the affordances of pairs of them, as a robot has explored them."""

    kind: Literal["meta_catalog"]
    """Says that this document is a meta-catalog."""
    robot: Name
    """Robot that explored it."""
    things: Annotated[dict[Name, KnownThing], Field(min_length=1)]
    """Nodes of the graph, by name."""
    pairs: dict[Name, PairSection] = {}
    """Edges of the graph, by name."""
    over: tuple[Name, ...] = ()
    """Meta-catalogs that this one joins."""
    steps: StepColumns | None = None
    """The actions in turn, by name of the pair."""
    provenance: CatalogProvenance | None = None


META_CATALOG = Kind(
    MetaCatalogDocument,
    folder="knowledge/meta_catalogs",
    checker="cbdsl.checking.knowledge.meta_catalog:examine_meta_catalog",
    unknown="CB660",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "things": {}},
)
