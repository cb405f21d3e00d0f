"""Noise of an image sensor."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Image

# Rows and columns by which an image may be shifted on the sheet.
_ROOM = 64


class PixelNoise:
    """Normal noise of each pixel and colour, rounded to steps of the sensor.

    Drawing new noise for every image takes as long as rendering. So it is drawn once per episode on
    a sheet larger than an image, and every image takes a part of the sheet.

    Args:
        deviation: Standard deviation, of 255.
        rng: Generator of the noise.
    """

    def __init__(self, deviation: float, rng: np.random.Generator) -> None:
        self._deviation, self._rng = deviation, rng
        self._sheets: dict[tuple[int, int], NDArray[np.int16]] = {}

    def added(self, image: Image) -> Image:
        """Return a copy of an image with noise, shape (height, width, 3)."""
        if not self._deviation:
            return image.copy()
        height, width, _ = image.shape
        sheet = self._sheets.get((height, width))
        if sheet is None:
            sheet = self._sheets[height, width] = self._draw(height + _ROOM, width + _ROOM)
        # Two images of an episode share a shift in one of 4096 cases only. Otherwise their noise is
        # uncorrelated pixel by pixel.
        down, right = self._rng.integers(_ROOM, size=2).tolist()
        part = sheet[down : down + height, right : right + width]
        noisy: Image = cv2.add(image, part, dtype=cv2.CV_8U)  # saturates
        return noisy

    def _draw(self, height: int, width: int) -> NDArray[np.int16]:
        values = self._rng.standard_normal((height, width, 3), dtype=np.float32)
        noise: NDArray[np.int16] = np.rint(values * self._deviation).astype(np.int16)
        return noise
