"""Errors of regions that are counted pixel by pixel."""

from __future__ import annotations

import math

import numpy as np

# Standard deviation of a region's area, px, per square root of its border's length, px, and per
# deviation of a pixel's value of 255: pixels that are half within it count or do not, and the noise
# of a sensor of 2 decides which.
_UNSURE = 0.15
# For how many regions errors are drawn at once.
_AHEAD = 256


class RegionErrors:
    """Errors of regions whose border pixels count or do not.

    Args:
        deviation: of a pixel's value, of 255.
        rng: draws them.
    """

    def __init__(self, deviation: float, rng: np.random.Generator) -> None:
        self._unsure, self._rng = _UNSURE * deviation, rng
        self._drawn: list[list[float]] = []

    def added(self, area: float, column: float, row: float) -> tuple[float, float, float]:
        """Area and centroid, px, with errors; a region keeps a pixel at least."""
        if not self._drawn:
            self._drawn = self._rng.standard_normal((_AHEAD, 3)).tolist()
        larger, aside, below = self._drawn.pop()
        radius = math.sqrt(area / math.pi)
        off = self._unsure * math.sqrt(2 * math.pi * radius)
        # Pixels of the border are a radius away from the centroid, on either side.
        shift = off * radius / area / math.sqrt(2)
        return max(area + off * larger, 1.0), column + shift * aside, row + shift * below
