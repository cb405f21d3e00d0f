"""One trial of Figure 3.6: a barcode in front of a camera, to be distinguished from two others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.api.sensing import Image
from cbdsl_reproduction.chapter_3.barcode import Barcode
from cbdsl_reproduction.chapter_3.barcode_reader import classify
from cbdsl_reproduction.chapter_3.lens import Lens

#: Focal length of the source's cameras, px at 640 x 480.
FOCAL_LENGTH = 837.0


@dataclass(frozen=True)
class BarcodeTrial:
    """Barcode in front of a camera, at any place and held by any hand.

    Attributes:
        picture: Scene in front of the camera's lens (``Cameras.resolve``), RGB.
        fineness: Factor by which it exceeds 640 x 480 pixels, along each axis.
        depth: Depth of the barcode along the camera's axis, m.
        barcode: Shown barcode.
        candidates: Class to which it is known to belong.
        seed: Seed of the sensor's noise.
    """

    picture: Image
    fineness: int
    depth: float
    barcode: Barcode
    candidates: tuple[Barcode, ...]
    seed: tuple[int, ...]

    def image(self, lens: Lens) -> Image:
        """Return the camera's image through a lens, RGB, shape (480, 640, 3)."""
        rng = np.random.default_rng(self.seed)
        return lens.photograph(self.picture, self.fineness, FOCAL_LENGTH, self.depth, rng)

    def is_read(self, lens: Lens) -> bool:
        """Return whether the robot identifies the barcode."""
        return classify(self.image(lens), self.candidates) is self.barcode
