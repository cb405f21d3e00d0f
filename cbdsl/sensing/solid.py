"""Size of an object that stands on a level, from its silhouettes in two images.

The object is modelled as an ellipsoid with one vertical axis. A far camera sees an ellipsoid with
the matrix A of its squared semi-axes as an ellipse with the matrix P A P^T, where P is the 2 x 3
Jacobian of the image coordinates at the centre. The ellipse with the moments M of a region has
4 M (Cross and Zisserman 1998: quadric reconstruction from dual-space geometry).

Two nearby cameras cannot separate the height from the depth. The centre is half the height above
the level that the object stands on, which gives the vertical axis; the horizontal block of A then
follows from six linear equations for three unknowns. The square of the vertical semi-axis is that
of half the height for a ball, and 4/3 of it for an upright box or cylinder. An object that is much
higher than wide is no ball.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Camera
from cbdsl.sensing.channels import Region
from cbdsl.sensing.kinematics import Frame

Floats = NDArray[np.float64]

# Square of a vertical semi-axis per square of half the height: of objects that may be a ball or a
# box, and of objects that are higher than wide by a factor.
_COMPACT, _COLUMN, _HIGH = 1.2, 4.0 / 3.0, 1.3
# Least height of an object, m.
_LEAST = 4e-3
# Least share of a new measurement in the mean of the last ones, which follow a turned object.
_NEWEST = 0.1
# Least ratio of horizontal extents with a direction, as measurements of a round object differ.
_ROUND = 1.15


class Silhouette(NamedTuple):
    """Region of an object in the image of one camera.

    Attributes:
        camera: Camera document.
        frame: Pose of the camera at the exposure, world frame.
        region: Whole region of the object.
    """

    camera: Camera
    frame: Frame
    region: Region


class Solid:
    """Mean of the measured sizes of one object.

    Attributes:
        level: Height of the level that the object stands on, m, world frame.
        height: Height of the object, m.
        footprint: Squares of the horizontal semi-axes, m^2, world axes, shape (2, 2).
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all measurements."""
        self._count = 0
        self.level = self.height = math.nan
        self.footprint: Floats = np.full((2, 2), np.nan)

    @property
    def is_known(self) -> bool:
        """True after the first measurement."""
        return self._count > 0

    def see(self, centre: Floats, level: float, silhouettes: Sequence[Silhouette]) -> None:
        """Update the mean by the silhouettes in the newest images.

        Args:
            centre: Triangulated centre of the silhouettes, m, world frame, shape (3,).
            level: Height of the level, m, world frame.
            silhouettes: Silhouette of the object in each camera.
        """
        self._count += 1
        share = max(1.0 / self._count, _NEWEST)
        height = max(2.0 * (float(centre[2]) - level), _LEAST)
        footprint = fit_footprint(centre, _COMPACT * (0.5 * height) ** 2, silhouettes)
        if height > _HIGH * extents_of(footprint)[1]:
            footprint = fit_footprint(centre, _COLUMN * (0.5 * height) ** 2, silhouettes)
        seen = level, height, footprint
        if self._count == 1:
            self.level, self.height, self.footprint = seen
            return
        self.level += share * (seen[0] - self.level)
        self.height += share * (seen[1] - self.height)
        self.footprint = self.footprint + share * (seen[2] - self.footprint)

    @property
    def extents(self) -> tuple[float, float]:
        """Longer and shorter horizontal extent, m."""
        return extents_of(self.footprint)

    def facing_down(self, centre: Floats) -> Floats:
        """Return the orientation of a tip above the object, shape (3, 3).

        Its z axis points down, and its x axis along the longer horizontal extent, away from the
        origin of the world frame. A round object has no longer extent; x then points away.

        Args:
            centre: Place of the object, m, world frame, shape (3,).
        """
        away = centre[:2] / max(math.hypot(*centre[:2].tolist()), 1e-9)
        along, across = self.extents
        if along > _ROUND * across:
            direction = np.linalg.eigh(self.footprint)[1][:, 1]
            away = direction if direction.dot(away) >= 0.0 else -direction
        x, y = away.tolist()
        return np.array([[x, y, 0.0], [y, -x, 0.0], [0.0, 0.0, -1.0]])


def extents_of(footprint: Floats) -> tuple[float, float]:
    """Return the longer and the shorter extent, m, of the squares of semi-axes, m^2, (2, 2)."""
    across, along = 2.0 * np.sqrt(np.maximum(np.linalg.eigvalsh(footprint), 0.0))
    return float(along), float(across)


def fit_footprint(centre: Floats, upright: float, silhouettes: Sequence[Silhouette]) -> Floats:
    """Return the squares of the horizontal semi-axes, m^2, world axes, shape (2, 2).

    Args:
        centre: Centre of the silhouettes, m, world frame, shape (3,).
        upright: Square of the vertical semi-axis, m^2.
        silhouettes: Silhouettes in at least one camera.
    """
    rows, squares = [], []
    for silhouette in silhouettes:
        image = _image_jacobian(silhouette.frame, centre)
        seen = 4.0 * _moments(silhouette) - upright * np.outer(image[:, 2], image[:, 2])
        for i, k in ((0, 0), (0, 1), (1, 1)):
            mixed = image[i, 0] * image[k, 1] + image[i, 1] * image[k, 0]
            rows.append((image[i, 0] * image[k, 0], mixed, image[i, 1] * image[k, 1]))
            squares.append(seen[i, k])
    (first, mixed, second), *_ = np.linalg.lstsq(np.array(rows), np.array(squares), rcond=None)
    return np.array([[first, mixed], [mixed, second]])


def _image_jacobian(frame: Frame, point: Floats) -> Floats:
    """Return the change of image coordinates, at focal length 1, per motion of a point, (2, 3)."""
    x, y, z = frame.rotation.T.dot(point - frame.position).tolist()
    local = np.array([[-y / x, 1.0, 0.0], [-z / x, 0.0, 1.0]]) / x
    jacobian: Floats = local.dot(frame.rotation.T)
    return jacobian


def _moments(silhouette: Silhouette) -> Floats:
    """Return the second moments of a region in image coordinates at focal length 1, (2, 2)."""
    own, length = silhouette.region.moments, silhouette.camera.focal_length
    # Columns run to the right and rows down, coordinates to the left and up: the signs cancel out.
    return np.array([[own.columns, own.mixed], [own.mixed, own.rows]]) / length**2
