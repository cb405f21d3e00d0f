"""Conversion of an exploration's knowledge of pairs to a meta-catalog document."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.documents.catalog import CatalogProvenance
from cbdsl.documents.meta_catalog import (
    ImpedanceSection,
    KnownThing,
    MetaCatalogDocument,
    PairSection,
)
from cbdsl.learning.catalogs.exploration import Exploration
from cbdsl.training.exploration.catalog_writing import affordance_values, step_columns
from cbdsl.training.exploration.explorable_pair import ExplorablePair


def meta_catalog_document(
    name: str,
    things: Mapping[str, KnownThing],
    relation: str,
    pairs: Mapping[str, ExplorablePair],
    exploration: Exploration,
    impedances: Mapping[str, ImpedanceSection],
    provenance: CatalogProvenance,
) -> MetaCatalogDocument:
    """Return the meta-catalog of an exploration.

    Args:
        name: Name of the document.
        things: Objects, by name.
        relation: Relation that the program of the pairs brings about.
        pairs: Explorable pairs by name.
        exploration: Exploration at its end.
        impedances: Measured impedances by name of the pair.
        provenance: Provenance of the meta-catalog.
    """
    sections = {}
    for key, pair in pairs.items():
        known = affordance_values(key, exploration, pair.program, pair.features)
        ends = {"upper": pair.upper, "lower": pair.lower, "relation": relation}
        sections[key] = PairSection(**ends, **known, impedance=impedances.get(key))
    return MetaCatalogDocument(
        cbdsl=1,
        kind="meta_catalog",
        name=name,
        robot=next(iter(pairs.values())).program.robot,
        things=dict(things),
        pairs=sections,
        over=tuple(dict.fromkeys(t.meta_catalog for t in things.values() if t.meta_catalog)),
        steps=step_columns(exploration),
        provenance=provenance,
    )
