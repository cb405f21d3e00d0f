"""One trial of Figure 3.6: a barcode in front of a camera, to be told from two others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.reproduction.barcode import Barcode
from cbdsl.reproduction.barcode_reader import classify
from cbdsl.reproduction.lens import Lens
from cbdsl.sensing.observation import Image

#: Focal length of the source's cameras, px at 640 x 480.
FOCAL_LENGTH = 837.0


@dataclass(frozen=True)
class BarcodeTrial:
    """A barcode, wherever it is and whoever holds it.

    Attributes:
        picture: what the camera's lens gets to see (``Cameras.resolve``), RGB.
        fineness: how many times as many pixels as 640 x 480 it has, each way.
        depth: of the barcode along the camera's axis, m.
        barcode: which one it is.
        candidates: the class that it is known to be of.
        seed: of the sensor's noise.
    """

    picture: Image
    fineness: int
    depth: float
    barcode: Barcode
    candidates: tuple[Barcode, ...]
    seed: tuple[int, ...]

    def image(self, lens: Lens) -> Image:
        """The camera's image through a lens, RGB, shape (480, 640, 3)."""
        rng = np.random.default_rng(self.seed)
        return lens.photograph(self.picture, self.fineness, FOCAL_LENGTH, self.depth, rng)

    def is_read(self, lens: Lens) -> bool:
        """Whether the robot tells which one it is."""
        return classify(self.image(lens), self.candidates) is self.barcode
