"""Recognition of pairs: which of those that are known two things look like (Section 7.3.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.affordance import AffordanceModel

Floats = NDArray[np.float64]

# Share of a Gaussian's samples that are nearer to its mean than what it is not taken for.
_BELIEVED = 0.999


class Recognition(NamedTuple):
    """Likeness of two things to a known pair.

    Attributes:
        pair: name of the pair that they look most like; ``None`` where they look like none.
        distance: Mahalanobis distance from that pair's features; infinite where there is no model.
    """

    pair: str | None
    distance: float


def recognise(models: Mapping[str, AffordanceModel], features: Floats) -> Recognition:
    """The pair that features belong to most likely, by the models of those that stayed.

    Args:
        models: of pairs by name, over the same features.
        features: of two things, shape (d,).
    """
    known = {name: model for name, model in models.items() if model.rewarded.weight > 0}
    if not known:
        return Recognition(None, math.inf)
    best = max(known, key=lambda name: known[name].log_density(features))
    distance = known[best].distance(features)
    return Recognition(best if distance <= _bound(len(features)) else None, distance)


def _bound(size: int) -> float:
    """Distance within which that share of a Gaussian's samples is, by the chi-squared law."""
    from scipy.special import gammaincinv  # which takes its time to import

    return math.sqrt(2.0 * float(gammaincinv(size / 2.0, _BELIEVED)))
