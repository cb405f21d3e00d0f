"""Models of catalogs: models from a document, for prediction."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cbdsl.documents.catalog import AffordanceSection, CatalogDocument, SampleModel
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.numeric.affordance_model import AffordanceModel, deviation_of
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.sample_statistics import SampleStatistics
from cbdsl.types.resource import AFFORDS, AffordanceProbability, Origin, Resource
from cbdsl.types.resource_type import PROBABILITY


def affordance_resource(
    catalog: CatalogDocument, action: str, resources: Mapping[str, Resource]
) -> Resource | None:
    """Return the resource ``affords.<action>``: Pr(reward | f, a) from the current features.

    Args:
        catalog: Catalog with the action.
        action: Name of the action.
        resources: Resources of the robot, by name.

    Returns:
        Resource, or ``None`` if a feature of its model cannot be read in advance, such as a drawn
        value.
    """
    own = catalog.affordances[action]
    signals = [resources.get(each.signal) for each in own.features.values()]
    features = tuple(each for each in signals if each is not None)
    # The robot may lack a signal of the catalog. A drawn reference has no value before its
    # controller is activated.
    if len(features) < len(signals) or any(each.is_drawn for each in features):
        return None
    source = AffordanceProbability(catalog.name, action, model_of(own, catalog), features)
    return Resource(f"{AFFORDS}{action}", PROBABILITY, Origin.ENVIRONMENT, source)


def models_of(catalog: CatalogDocument) -> dict[str, AffordanceModel]:
    """Return the models of a catalog's actions by name; without features, they hold counts only."""
    return {name: model_of(each, catalog) for name, each in catalog.affordances.items()}


def pair_models(catalog: MetaCatalogDocument) -> dict[str, AffordanceModel]:
    """Return the models of a meta-catalog's pairs by name."""
    return {name: model_of(each, catalog) for name, each in catalog.pairs.items()}


def model_of(
    affordance: AffordanceSection, catalog: CatalogDocument | MetaCatalogDocument
) -> AffordanceModel:
    """Return the model of one action of a catalog, with the prior used during exploration."""
    constants = {} if catalog.provenance is None else catalog.provenance.constants
    # A catalog without provenance has the default constants of an exploration: deviations of the
    # workspace, and a prior of one sample.
    in_si = constants.get("units") == "si"
    scale = np.array(
        [
            1.0 if in_si else deviation_of(feature.unit)
            for feature in affordance.features.values()
            for _ in range(feature.components)
        ]
    )
    return AffordanceModel(
        scale,
        float(constants.get("prior", 1.0)),
        affordance.tried,
        affordance.rewarded,
        _samples(affordance.with_reward, len(scale)),
        _samples(affordance.without_reward, len(scale)),
    )


def _samples(model: SampleModel | None, size: int) -> SampleStatistics:
    if model is None:
        return SampleStatistics.empty(size)
    return SampleStatistics.of(float(model.count), np.array(model.mean), np.array(model.covariance))


def predict(
    affordance: AffordanceSection, model: AffordanceModel, ahead: Mapping[str, tuple[float, ...]]
) -> float:
    """Return Pr(reward | f, a) from the features before the action, or Pr(reward | a) without."""
    features = _vector(affordance, model, ahead)
    return model.reward_probability if features is None else model.reward_given(features)


def is_known(
    affordance: AffordanceSection, model: AffordanceModel, ahead: Mapping[str, tuple[float, ...]]
) -> bool:
    """Return whether an action was tried with features like those before the action."""
    features = _vector(affordance, model, ahead)
    return features is None or model.knows(features)


def _vector(
    affordance: AffordanceSection, model: AffordanceModel, ahead: Mapping[str, tuple[float, ...]]
) -> Floats | None:
    """Return the components of a model's features, or ``None`` if some are undefined."""
    if not affordance.features or not all(name in ahead for name in affordance.features):
        return None
    numbers = [value for name in affordance.features for value in ahead[name]]
    return np.array(numbers) if len(numbers) == len(model.scale) else None
