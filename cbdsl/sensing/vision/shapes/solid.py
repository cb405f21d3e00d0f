"""Size of an object that stands on a level, from its silhouettes in two images.

The model is an ellipsoid with one vertical axis, and A the matrix of its squared semi-axes. A far
camera sees it as an ellipse with the matrix P A P^T. P is the 2 x 3 Jacobian of the image
coordinates at the centre. The ellipse with the moments M of a region has 4 M
(Cross and Zisserman 1998: quadric
reconstruction from dual-space geometry).

Two silhouettes give six linear equations for the vertical axis and the horizontal block of A, four
unknowns. Two nearby cameras separate height and depth only weakly. A seventh equation states the
vertical axis as expected from the height. Its square is that of half the height for a ball, and 4/3
of it for an upright box or cylinder. All equations are weighted by their errors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.documents.robot import Camera
from cbdsl.kinematics.kinematics import Frame
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.channels import Region

# Expected square of a vertical semi-axis per square of half the height.
_UPRIGHT = 1.2
# Errors of that square, and of the squares of a silhouette's axes, as shares of the largest one.
_EXPECTED, _SEEN = 0.15, 0.02
# Margin of the top, m, of an object that is higher than wide by a factor, and not longer than wide
# by another. Bottles narrow upwards: they are higher than their silhouette's centre shows.
_TOP, _HIGH, _LONG = 0.035, 1.3, 1.6
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
        rise: Height of the seen centre above the level, m.
        footprint: Squares of the horizontal semi-axes, m^2, world axes, shape (2, 2).
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all measurements."""
        self._count = 0
        self.level = self.height = self.rise = math.nan
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
        rise = float(centre[2]) - level
        height = fit_height(centre, rise, silhouettes)
        footprint = fit_footprint(centre, height, silhouettes)
        if self._count == 1:
            self.level, self.rise, self.height, self.footprint = level, rise, height, footprint
            return
        self.level += share * (level - self.level)
        self.rise += share * (rise - self.rise)
        self.height += share * (height - self.height)
        self.footprint = self.footprint + share * (footprint - self.footprint)

    @property
    def extents(self) -> tuple[float, float]:
        """Longer and shorter horizontal extent, m."""
        return extents_of(self.footprint)

    @property
    def bulk(self) -> float:
        """Edge of a cube with the volume of the ellipsoid, m."""
        along, across = self.extents
        return math.cbrt(math.pi / 6.0 * along * across * self.height)

    @property
    def top(self) -> float:
        """Height of the top, m, world frame."""
        along, across = self.extents
        may_narrow = self.height > _HIGH * across and along < _LONG * across
        return self.level + self.height + (_TOP if may_narrow else 0.0)

    def facing_down(self, centre: Floats) -> Floats:
        """Return the orientation of a tip above the object, shape (3, 3).

        Its z axis points down, and its x axis along the longer horizontal extent, away from the
        origin of the world frame. A round object has no longer extent; x then points away.

        Args:
            centre: Place of the object, m, world frame, shape (3,).
        """
        away = _direction(centre[:2])
        along, across = self.extents
        if along > _ROUND * across:
            direction = np.linalg.eigh(self.footprint)[1][:, 1]
            away = direction if direction.dot(away) >= 0.0 else -direction
        x, y = away.tolist()
        return np.array([[x, y, 0.0], [y, -x, 0.0], [0.0, 0.0, -1.0]])

    def facing_aside(self, centre: Floats, start: Floats) -> Floats:
        """Return the orientation of a tip beside the object, shape (3, 3).

        Its x axis points up. Its z axis is level and points away from the start, along the nearest
        horizontal axis of the object. If the object is round, it points straight away.

        Args:
            centre: Place of the object, m, world frame, shape (3,).
            start: Place from which the tip comes, m, world frame, shape (3,).
        """
        away = _direction(centre[:2] - start[:2])
        along, across = self.extents
        if along > _ROUND * across:
            axes = np.linalg.eigh(self.footprint)[1]
            shares = axes.T.dot(away)
            nearest = int(np.argmax(np.abs(shares)))
            away = math.copysign(1.0, shares[nearest]) * axes[:, nearest]
        x, y = away.tolist()
        return np.array([[0.0, y, x], [0.0, -x, y], [1.0, 0.0, 0.0]])


def _direction(vector: Floats) -> Floats:
    """Return a horizontal vector of length 1, shape (2,)."""
    direction: Floats = vector / max(math.hypot(*vector.tolist()), 1e-9)
    return direction


def extents_of(footprint: Floats) -> tuple[float, float]:
    """Return the longer and the shorter extent, m, of the squares of semi-axes, m^2, (2, 2)."""
    across, along = 2.0 * np.sqrt(np.maximum(np.linalg.eigvalsh(footprint), 0.0))
    return float(along), float(across)


def fit_height(centre: Floats, rise: float, silhouettes: Sequence[Silhouette]) -> float:
    """Return the height of an object from the height of its seen centre, m.

    Nearer parts look larger, by the square of the distance r. The seen centre is therefore above
    the middle of an ellipsoid of height h: by h^2 / 20 times the change of log(1 / r^2) per height.

    Args:
        centre: Centre of the silhouettes, m, world frame, shape (3,).
        rise: Height of the centre above the level, m.
        silhouettes: Silhouettes in two cameras.
    """
    eye = np.mean([each.frame.position for each in silhouettes], axis=0)
    growth = 2.0 * float(eye[2] - centre[2]) / math.dist(eye, centre) ** 2 / 20.0
    if rise <= 0.0 or growth <= 0.0:
        return max(2.0 * rise, _LEAST)
    # The root of growth h^2 + h / 2 = rise.
    return max((math.sqrt(0.25 + 4.0 * growth * rise) - 0.5) / (2.0 * growth), _LEAST)


def fit_footprint(centre: Floats, height: float, silhouettes: Sequence[Silhouette]) -> Floats:
    """Return the squares of the horizontal semi-axes, m^2, world axes, shape (2, 2).

    Args:
        centre: Centre of the silhouettes, m, world frame, shape (3,).
        height: Height of the object, m.
        silhouettes: Silhouettes in two cameras.
    """
    rows, squares = [], []
    for silhouette in silhouettes:
        away = math.dist(centre, silhouette.frame.position)
        image = away * _image_jacobian(silhouette.frame, centre)
        seen = 4.0 * away**2 * _moments(silhouette)
        scale = 1.0 / (_SEEN * float(np.linalg.norm(seen)))
        for i, k in ((0, 0), (0, 1), (1, 1)):
            (a, b, c), (d, e, f) = image[i].tolist(), image[k].tolist()
            rows.append((scale * a * d, scale * (a * e + b * d), scale * b * e, scale * c * f))
            squares.append(scale * seen[i, k])
    expected = _UPRIGHT * (0.5 * height) ** 2
    rows.append((0.0, 0.0, 0.0, 1.0 / (_EXPECTED * expected)))
    squares.append(1.0 / _EXPECTED)
    (first, mixed, second, _), *_ = np.linalg.lstsq(np.array(rows), np.array(squares), rcond=None)
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
