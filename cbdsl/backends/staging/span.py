"""Spans of numbers, from which documents let values be drawn."""

from __future__ import annotations

import numpy as np

Span = tuple[float, float]


def draw(span: Span, rng: np.random.Generator) -> float:
    """Draw from the uniform distribution over a span."""
    return float(rng.uniform(*span))
