"""Sightings: the lines of sight to the regions of an image."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.channels import Region
from cbdsl.sensing.stereo import Ray

Floats = NDArray[np.float64]


class Sighting(NamedTuple):
    """The line of sight to a region.

    Attributes:
        region: in the image.
        ray: the line of sight to its centroid, as long as it is to the plane x = 1 m of the
            camera's frame.
        scale: how much the pinhole enlarges areas there, as ``line_of_sight`` has it.
        focal_length: of the camera, px.
        time: when, s.
        image: number of the image.
    """

    region: Region
    ray: Ray
    scale: float
    focal_length: float
    time: float
    image: int

    def distance(self, point: Floats) -> float:
        """Distance of a point from the line, m; infinite behind the camera.

        Args:
            point: m, world frame, shape (3,).
        """
        origin, direction, length = self.ray
        x, y, z = point.tolist()
        a, b, c = origin.tolist()
        u, v, w = direction.tolist()
        x, y, z = x - a, y - b, z - c
        along = (x * u + y * v + z * w) / length
        if along <= 0.0:
            return math.inf
        return math.sqrt(max(x * x + y * y + z * z - along * along, 0.0))

    def radius(self, point: Floats) -> float:
        """Radius of a ball at a point that would look as large as the region, m."""
        offset = (point - self.ray.origin) / self.focal_length
        return math.sqrt(self.region.area * self.scale * float(offset.dot(offset)) / math.pi)
