"""Blobs: ellipses that approximate regions (Fig 7.15), as angles in a camera's headings."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.documents.robot import Camera
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.channels import Region
from cbdsl.sensing.vision.regions.camera import sight, sighting_jacobian

# Least ratio of the axes of a blob with an orientation: a ball appears as an ellipse of ratio 1.07
# in a corner of the image, and pixels turn a small ball into an ellipse of ratio 1.1.
_LEAST_RATIO = 1.15


class Blob(NamedTuple):
    """Ellipse with the same second moments as a region.

    Attributes:
        extent: Semi-axes du and dv, the longer one first, rad, shape (2,).
        orientation: Angle of the longer axis from the azimuth (to the left) towards the elevation,
            rad, above -pi/2 up to pi/2; ``None`` if the axes are too similar.
    """

    extent: Floats
    orientation: float | None


def blob_of(camera: Camera, region: Region) -> Blob:
    """Return the blob of a whole region, in the headings around its own."""
    slopes = sighting_jacobian(sight(camera, region.column, region.row))[:, 1:]
    own = region.moments
    # Columns run to the right and rows down, headings to the left and up: the signs cancel out.
    pixels = np.array([[own.columns, own.mixed], [own.mixed, own.rows]])
    spread = slopes.dot(pixels).dot(slopes.T) / camera.focal_length**2
    # The eigenvalues of [[a, b], [b, c]] are (a + c) / 2 +- hypot((a - c) / 2, b). The axis of the
    # larger one is at half of the angle atan2(2 b, a - c).
    (azimuth, mixed), (_, elevation) = spread.tolist()
    middle, half = (azimuth + elevation) / 2, math.hypot((azimuth - elevation) / 2, mixed)
    # A uniform ellipse has a variance of a quarter of its semi-axis squared.
    longer, shorter = 2 * math.sqrt(middle + half), 2 * math.sqrt(max(middle - half, 0.0))
    round_one = longer < _LEAST_RATIO * shorter
    angle = None if round_one else 0.5 * math.atan2(2 * mixed, azimuth - elevation)
    return Blob(np.array([longer, shorter]), angle)
