"""Sightings: lines of sight to the regions of an image."""

from __future__ import annotations

import math
from typing import NamedTuple

from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.channels import Region
from cbdsl.sensing.vision.association.stereo import Ray


class Sighting(NamedTuple):
    """Line of sight to a region.

    Attributes:
        region: Region in the image.
        ray: Line of sight to the centroid, up to the plane x = 1 m of the camera's frame.
        scale: Factor by which the pinhole enlarges areas there, as in ``line_of_sight``.
        focal_length: Focal length of the camera, px.
        time: Time of the image, s.
        image: Number of the image.
    """

    region: Region
    ray: Ray
    scale: float
    focal_length: float
    time: float
    image: int

    def distance(self, point: Floats) -> float:
        """Return the distance of a point from the line, m; infinite behind the camera.

        Args:
            point: Point, m, world frame, shape (3,).
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
        """Return the radius of a ball at a point with the apparent size of the region, m."""
        offset = (point - self.ray.origin) / self.focal_length
        return math.sqrt(self.region.area * self.scale * float(offset.dot(offset)) / math.pi)
