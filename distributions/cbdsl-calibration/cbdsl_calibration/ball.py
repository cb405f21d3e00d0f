"""Ball in the hand: its position by touch, and its image in a camera."""

from __future__ import annotations

import numpy as np

from cbdsl.api.documents import Camera
from cbdsl.extend.backend import Floats

# Distance by which a fingertip must be nearer to a camera to hide e times as much of the ball, m.
_NEARER = 0.005
# Smallest distance before a camera, m; intermediate estimates may try smaller ones.
_CLOSEST = 1e-3


def plane_of(tips: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the axes of planes through three fingertips, shape (n, 3) each; the third is normal.

    Args:
        tips: Centres of the fingertips, m, shape (n, 3, 3).
    """
    first = _unit(tips[:, 1] - tips[:, 0])
    across = tips[:, 2] - tips[:, 0]
    second = _unit(across - np.sum(across * first, axis=1, keepdims=True) * first)
    return first, second, np.cross(first, second)


def centre(tips: Floats, distances: Floats, side: float) -> Floats:
    """Return the centres of balls at given distances from three fingertips, m, shape (n, 3).

    The centre of a ball that rolls between the fingertips keeps these distances. If they are too
    short to meet, the centre is in the plane of the fingertips.

    Args:
        tips: Centres of the fingertips, m, shape (n, 3, 3).
        distances: Distances from the fingertips, m, shape (3,) or, for each ball, (n, 3).
        side: Side of the fingertips' plane with the centre, 1 or -1 by its normal.
    """
    # Trilateration, with the first fingertip as the origin, the second at (w, 0), and the third at
    # (l, c). The equations are |p - tip|^2 = distance^2. Their differences are linear in x and y.
    # The height follows from the first equation, up to its sign.
    first, second, normal = plane_of(tips)
    width = np.sum((tips[:, 1] - tips[:, 0]) * first, axis=1)
    along = np.sum((tips[:, 2] - tips[:, 0]) * first, axis=1)
    across = np.sum((tips[:, 2] - tips[:, 0]) * second, axis=1)
    a, b, c = np.moveaxis(distances**2, -1, 0)
    x = (a - b + width**2) / (2 * width)
    y = (a - c + along**2 + across**2 - 2 * along * x) / (2 * across)
    height = np.sqrt(np.maximum(a - x**2 - y**2, 0.0))
    inner: Floats = x[:, None] * first + y[:, None] * second + side * height[:, None] * normal
    return tips[:, 0] + inner


def image(camera: Camera, points: Floats, radius: float) -> tuple[Floats, Floats]:
    """Return centroids, px, shape (n, 2), and areas, px, shape (n,), of a ball's images.

    A pinhole camera sees a ball as an ellipse, whose centre differs slightly from the image of the
    ball's centre.

    Args:
        camera: Camera with image size and focal length.
        points: Centres in the camera's frame, m, shape (n, 3).
        radius: Radius of the ball, m.
    """
    x, y, z = np.maximum(points[:, 0], max(1.01 * radius, _CLOSEST)), points[:, 1], points[:, 2]
    # The rays tangent to a ball at (x, y, z) form a cone, whose section with the image plane is an
    # ellipse. Its centre is f x (y, z) / (x^2 - r^2). Its area is pi f^2 r^2 sqrt(x^2 + y^2 + z^2 -
    # r^2) / (x^2 - r^2)^(3/2).
    inner = x**2 - radius**2
    scale = camera.focal_length * x / inner
    centroids = np.stack((camera.width / 2 - scale * y, camera.height / 2 - scale * z), axis=1)
    outer = np.sqrt(x**2 + y**2 + z**2 - radius**2)
    areas = np.pi * (camera.focal_length * radius) ** 2 * outer / inner**1.5
    return centroids, areas


def hidden(
    centroids: Floats, shares: Floats, tips: Floats, distances: Floats, rim: Floats
) -> Floats:
    """Return the displacements of a ball's centroids by occluding fingers, px, shape (n, 2).

    The hidden part is at the rim, near the fingertips that are nearest to the camera.

    Args:
        centroids: Centroids of the whole ball, px, shape (n, 2).
        shares: Visible shares of its area, shape (n,).
        tips: Image points of the fingertips, px, shape (n, 3, 2).
        distances: Distances of the fingertips from the camera, m, shape (n, 3).
        rim: Radii of the ball's images, px, shape (n,).
    """
    # A small hidden part of the share m at the rim lies about r from the centroid. So the centroid
    # of the rest moves by about m r away from it.
    missing = np.clip(1.0 - shares, 0.0, 1.0)
    parts = np.exp((distances.min(axis=1, keepdims=True) - distances) / _NEARER)
    parts /= parts.sum(axis=1, keepdims=True)
    directions = tips - centroids[:, None]
    directions /= np.maximum(np.linalg.norm(directions, axis=2, keepdims=True), 1e-9)
    displacements: Floats = -(missing * rim)[:, None] * np.einsum("nk,nki->ni", parts, directions)
    return displacements


def _unit(vectors: Floats) -> Floats:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    units: Floats = vectors / np.maximum(lengths, 1e-9)
    return units
