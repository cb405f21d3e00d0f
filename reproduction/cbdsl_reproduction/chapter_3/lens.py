"""Lens and sensor of a camera, which turn an ideal picture into an image."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cbdsl.api.sensing import Image


@dataclass(frozen=True)
class Lens:
    """Lens of fixed focus, and the noise of the sensor behind it.

    Attributes:
        spread: Standard deviation of the point spread in focus, px.
        noise: Standard deviation of pixel values, on the scale of 0 to 255.
        aperture: Diameter of the pupil, m; 0 for a lens that is in focus everywhere.
        focus: Distance at which the lens is in focus, m.
    """

    spread: float
    noise: float
    aperture: float = 0.0
    focus: float = math.inf

    def blur(self, focal_length: float, distance: float) -> float:
        """Return the point spread's standard deviation, px, at a distance, m; focal length in px.

        A point out of focus becomes a disc, and a disc's deviation is a quarter of its diameter.
        """
        # Thin lens, much nearer to its sensor than to the scene: a point at distance z becomes a
        # disc of the diameter f A |1/z_0 - 1/z|, with the focal length f, the pupil A and the focus
        # z_0. Blurs act one after the other, as convolutions, so that their variances add up.
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
        """Return an image of a scene at a distance.

        Args:
            fine: Picture in front of the lens, RGB, with ``times`` as many pixels along each axis.
            times: Factor of the resolution, at least 2, so that the lens acts before the pixels.
            focal_length: Focal length of the image, px.
            distance: Distance of the relevant object, m.
            rng: Random generator of the noise.

        Returns:
            RGB image, shape (height, width, 3).
        """
        deviation = times * self.blur(focal_length, distance)
        seen = cv2.GaussianBlur(fine, (0, 0), deviation)
        # A pixel of a sensor collects the light on its whole area, which ``INTER_AREA`` averages.
        size = (fine.shape[1] // times, fine.shape[0] // times)
        values = cv2.resize(seen, size, interpolation=cv2.INTER_AREA).astype(np.float32)
        values += self.noise * rng.standard_normal(values.shape, dtype=np.float32)
        image: Image = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        return image
