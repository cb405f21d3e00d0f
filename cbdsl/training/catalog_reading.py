"""Catalogs as they are read: the models of a document, to predict with."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cbdsl.documents.catalog import AffordanceSection, CatalogDocument, SampleModel
from cbdsl.learning.affordance import AffordanceModel
from cbdsl.learning.exploration import deviation_of
from cbdsl.learning.gaussian import Gaussian


def models_of(catalog: CatalogDocument) -> dict[str, AffordanceModel]:
    """Models of a catalog's actions by name; one without features knows its counts alone."""
    return {name: _model(each) for name, each in catalog.affordances.items()}


def _model(affordance: AffordanceSection) -> AffordanceModel:
    scale = np.array(
        [
            deviation_of(feature.unit)
            for feature in affordance.features.values()
            for _ in range(feature.components)
        ]
    )
    return AffordanceModel(
        scale,
        1.0,
        affordance.tried,
        affordance.rewarded,
        _samples(affordance.with_reward, len(scale)),
        _samples(affordance.without_reward, len(scale)),
    )


def _samples(model: SampleModel | None, size: int) -> Gaussian:
    if model is None:
        return Gaussian.empty(size)
    return Gaussian.of(float(model.count), np.array(model.mean), np.array(model.covariance))


def predict(
    affordance: AffordanceSection,
    model: AffordanceModel,
    ahead: Mapping[str, tuple[float, ...]],
) -> float:
    """Probability that an action is rewarded, by what is seen before it; Pr(reward | a) unseen."""
    if not affordance.features or not all(name in ahead for name in affordance.features):
        return model.reward_probability
    numbers = [value for name in affordance.features for value in ahead[name]]
    if len(numbers) != len(model.scale):
        return model.reward_probability
    return model.reward_given(np.array(numbers))
