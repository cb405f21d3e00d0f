"""The lens and the sensor of a camera: how an ideal picture becomes an image."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cbdsl.sensing.observation import Image


@dataclass(frozen=True)
class Lens:
    """A lens of fixed focus, and the noise of the sensor behind it.

    Attributes:
        spread: standard deviation of the point spread in focus, px.
        noise: standard deviation of pixel values, of 255.
        aperture: diameter of the pupil, m; 0 for a lens that is in focus everywhere.
        focus: distance at which it is in focus, m.
    """

    spread: float
    noise: float
    aperture: float = 0.0
    focus: float = math.inf

    def blur(self, focal_length: float, distance: float) -> float:
        """Standard deviation of the point spread at a distance, m, by a focal length in px: px.

        A point out of focus becomes a disc, and a disc's deviation is a quarter of its diameter.
        """
        disc = focal_length * self.aperture * abs(1 / self.focus - 1 / distance)
        return math.hypot(self.spread, disc / 4)

    def photograph(
        self,
        fine: Image,
        times: int,
        focal_length: float,
        distance: float,
        rng: np.random.Generator,
    ) -> Image:
        """An image of what is at a distance.

        Args:
            fine: the picture before the lens, RGB, with ``times`` as many pixels each way.
            times: how much finer it is; at least 2, so that the lens comes before the pixels.
            focal_length: of the image, px.
            distance: of what matters in it, m.
            rng: draws the noise.

        Returns:
            RGB, shape (height, width, 3).
        """
        deviation = times * self.blur(focal_length, distance)
        seen = cv2.GaussianBlur(fine, (0, 0), deviation)
        size = (fine.shape[1] // times, fine.shape[0] // times)
        values = cv2.resize(seen, size, interpolation=cv2.INTER_AREA).astype(np.float32)
        values += self.noise * rng.standard_normal(values.shape, dtype=np.float32)
        image: Image = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        return image
