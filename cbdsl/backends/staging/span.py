"""Spans of numbers, as documents give what is left to chance."""

from __future__ import annotations

import numpy as np

Span = tuple[float, float]


def draw(span: Span, rng: np.random.Generator) -> float:
    """Draw from the uniform distribution over a span."""
    return float(rng.uniform(*span))
