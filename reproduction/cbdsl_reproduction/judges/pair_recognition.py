"""Recognition of pairs: the known pair that two objects resemble most (Section 7.3.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.api.control import Floats
from cbdsl.api.learning import AffordanceModel

#: Likeness from which two objects are recognised as a pair.
LEAST_LIKENESS = 1e-3


class Recognition(NamedTuple):
    """Similarity of two objects to a known pair.

    Attributes:
        pair: Name of the most similar pair; ``None`` if none is similar enough.
        distance: Mahalanobis distance from that pair's features; infinite without a model.
    """

    pair: str | None
    distance: float


def recognise(models: Mapping[str, AffordanceModel], features: Floats) -> Recognition:
    """Return the most likely pair of the features, by the models of pairs that stayed.

    Args:
        models: Models of pairs by name, over the same features.
        features: Features of two objects, shape (d,).
    """
    known = {name: model for name, model in models.items() if model.rewarded.weight > 0}
    if not known:
        return Recognition(None, math.inf)
    best = max(known, key=lambda name: known[name].log_density(features))
    is_like = known[best].likeness(features) >= LEAST_LIKENESS
    return Recognition(best if is_like else None, known[best].distance(features))
