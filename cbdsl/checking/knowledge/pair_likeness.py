"""Resources by which programs recognise the pairs of a meta-catalog (Section 7.3.1)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.robot.pair_names import pair_resource
from cbdsl.types.resource import LIKENESS_OF, Origin, PairLikeness, Resource
from cbdsl.types.resource_type import LIKENESS

if TYPE_CHECKING:
    from cbdsl.numeric.affordance_model import AffordanceModel


class _PairModel:
    """Model of a pair of a meta-catalog, computed at its first use.

    Args:
        catalog: Meta-catalog with the pair.
        pair: Name of the pair.
    """

    def __init__(self, catalog: MetaCatalogDocument, pair: str) -> None:
        self._catalog, self._pair = catalog, pair

    def __call__(self) -> AffordanceModel:
        """Return the model."""
        return self._model

    @cached_property
    def _model(self) -> AffordanceModel:
        # Validation needs no model, and starts without numpy.
        from cbdsl.program.catalog_models import model_of

        return model_of(self._catalog.pairs[self._pair], self._catalog)


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
    source = PairLikeness(catalog.name, pair, _PairModel(catalog, pair), features)
    return Resource(f"{LIKENESS_OF}{pair}", LIKENESS, Origin.ENVIRONMENT, source)
