"""Meta-catalogs as they are written: what an exploration of pairs knows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.documents.catalog import CatalogProvenance
from cbdsl.documents.meta_catalog import KnownThing, MetaCatalogDocument, PairSection
from cbdsl.learning.exploration import Exploration
from cbdsl.training.catalog_writing import affordance_values, step_columns

if TYPE_CHECKING:
    from cbdsl.training.pair_task import PairTask


def meta_catalog_document(
    name: str, task: PairTask, exploration: Exploration, provenance: CatalogProvenance
) -> MetaCatalogDocument:
    """Meta-catalog of an exploration.

    Args:
        name: of the document.
        task: has the things and the pairs.
        exploration: at its end.
        provenance: where it comes from.
    """
    pairs = {}
    for key, pair in task.pairs.items():
        known = affordance_values(key, exploration, pair.program, pair.features)
        ends = {"upper": pair.upper, "lower": pair.lower, "relation": task.relation}
        pairs[key] = PairSection(**ends, **known)
    return MetaCatalogDocument(
        cbdsl=1,
        kind="meta_catalog",
        name=name,
        robot=task.robot.name,
        things={key: KnownThing(feature=channel) for key, channel in task.things.items()},
        pairs=pairs,
        steps=step_columns(exploration),
        provenance=provenance,
    )
