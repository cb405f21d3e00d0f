"""Errors of regions that are counted pixel by pixel."""

# Model: the sensor's noise decides for each pixel of a region's border whether it counts. Let the
# border have n = 2 pi r pixels with independent errors of standard deviation s, where r is the
# radius of a disc with the region's area A. Then
#     deviation of the area       s sqrt(n)
#     deviation of the centroid   s sqrt(n / 2) r / A, in each direction
# since the error of a border pixel at the angle phi shifts the centroid by r cos(phi) / A, and the
# mean of cos(phi)^2 is 1/2. Assumptions: the region is nearly round, and s is proportional to the
# noise of a pixel. A long, thin region has a longer border than its disc, and larger errors.

from __future__ import annotations

import math

import numpy as np

# Standard deviation of a region's area, px, per square root of its border's length, px, and per
# deviation of a pixel's value of 255. The noise of the sensor, of 2,
# decides whether a pixel that is half within the region counts.
_UNSURE = 0.15
# Number of regions for which errors are drawn at a time.
_AHEAD = 256


class RegionErrors:
    """Errors of regions whose border pixels may count or not.

    Args:
        deviation: Standard deviation of a pixel's value, of 255.
        rng: Generator of the errors.
    """

    def __init__(self, deviation: float, rng: np.random.Generator) -> None:
        self._unsure, self._rng = _UNSURE * deviation, rng
        self._drawn: list[list[float]] = []

    def added(self, area: float, column: float, row: float) -> tuple[float, float, float]:
        """Return area and centroid, px, with errors; a region keeps at least one pixel."""
        if not self._drawn:
            self._drawn = self._rng.standard_normal((_AHEAD, 3)).tolist()
        larger, aside, below = self._drawn.pop()
        radius = math.sqrt(area / math.pi)
        off = self._unsure * math.sqrt(2 * math.pi * radius)
        # Pixels of the border are a radius away from the centroid, on either side.
        shift = off * radius / area / math.sqrt(2)
        return max(area + off * larger, 1.0), column + shift * aside, row + shift * below
