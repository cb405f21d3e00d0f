"""Predicted signals: probabilities and likenesses, computed from other resources."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import AffordanceProbability, PairLikeness, Resource


class PredictedSignals:
    """Reader of signals that models predict from features.

    Args:
        read: Function that reads a resource.
        clock: Count of the postures, shape (1,).
        vision: Vision, which counts the images.
    """

    def __init__(
        self, read: Callable[[Resource], Reading | None], clock: Integers, vision: Vision
    ) -> None:
        self._read, self._clock, self._vision = read, clock, vision

    def affordance(self, source: AffordanceProbability) -> Reading | None:
        """Return Pr(reward | f, a) for the current features.

        It is ``None`` while a feature is undefined, or unlike all that were tried.
        """
        features = self._features(source.features)
        if features is None or not source.model.knows(features):
            return None
        probability = source.model.reward_given(features)
        return Reading(np.array([probability]), None, int(self._clock[0]))

    def likeness(self, source: PairLikeness) -> Reading | None:
        """Return the likeness of two objects to a pair, ``None`` while a feature is undefined."""
        features = self._features(source.features)
        if features is None:
            return None
        return Reading(np.array([source.model.likeness(features)]), None, self._vision.images)

    def _features(self, resources: Iterable[Resource]) -> Floats | None:
        """Return the components of some resources, ``None`` while one is undefined."""
        readings = [self._read(resource) for resource in resources]
        values = [reading.value.ravel() for reading in readings if reading is not None]
        return np.concatenate([*values, np.zeros(0)]) if len(values) == len(readings) else None
