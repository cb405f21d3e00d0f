"""Resources by which programs recognise the pairs of a meta-catalog (Section 7.3.1)."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.program.catalog_models import model_of
from cbdsl.robot.pair_names import pair_resource
from cbdsl.types.resource import LIKENESS_OF, Origin, PairLikeness, Resource
from cbdsl.types.resource_type import LIKENESS


def likeness_resource(
    catalog: MetaCatalogDocument, pair: str, resources: Mapping[str, Resource]
) -> Resource | None:
    """Return the resource ``likeness.<pair>`` of a pair of a meta-catalog.

    Args:
        catalog: Meta-catalog with the pair.
        pair: Name of the pair.
        resources: Resources of the robot, by name.

    Returns:
        Resource, or ``None`` if the pair never stayed, or the robot lacks a feature of its model.
    """
    own = catalog.pairs[pair]
    signals = [pair_resource(each.signal, resources) for each in own.features.values()]
    features = tuple(each for each in signals if each is not None)
    if own.with_reward is None or not features or len(features) < len(signals):
        return None
    source = PairLikeness(catalog.name, pair, model_of(own, catalog), features)
    return Resource(f"{LIKENESS_OF}{pair}", LIKENESS, Origin.ENVIRONMENT, source)
