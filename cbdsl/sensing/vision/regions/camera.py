"""Pinhole camera: pixels, lines of sight and headings."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.documents.robot import Camera
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once


def sight(camera: Camera, column: float, row: float) -> Floats:
    """Return a pixel's direction, camera frame (x forward, y left, z up), with x = 1, shape (3,).

    Args:
        camera: Camera of the pixel.
        column: Distance from the left edge, px; the centre of the first pixel is at 0.5.
        row: Distance from the top edge, px.
    """
    return np.array(
        [
            1.0,
            (camera.width / 2 - column) / camera.focal_length,
            (camera.height / 2 - row) / camera.focal_length,
        ]
    )


def within_view(camera: Camera, centre: Floats, radius: float) -> bool:
    """Return whether the whole image of a ball is within the camera's image.

    Args:
        camera: Camera of the image.
        centre: Centre of the ball in the camera frame, m, shape (3,).
        radius: Radius of the ball, m.
    """
    x, y, z = centre.tolist()
    # The border of the view is a slanted plane. Its slant, sqrt(1 + (width / 2 f)^2), is neglected.
    largest = x / (2 * camera.focal_length)
    return x > 0.0 and all(
        abs(across) + radius <= largest * pixels
        for across, pixels in ((y, camera.width), (z, camera.height))
    )


def heading(direction: Floats) -> Floats:
    """Return azimuth (left positive) and elevation (up positive) of a vector, rad, shape (2,)."""
    x, y, z = direction.tolist()
    return np.array([math.atan2(y, x), math.atan2(z, math.hypot(x, y))])


def direction(angles: Floats) -> Floats:
    """Return the unit vector with the given heading, shape (3,)."""
    azimuth, elevation = angles.tolist()
    return np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )


@compiled_once
def heading_jacobian(angles: Floats) -> Floats:
    """Return the change of a heading per rotation of the camera about its own axes, shape (2, 3).

    The point is assumed to be far away compared with the camera's own displacement.
    """
    azimuth, elevation = angles[0], angles[1]
    # The point turns by -omega in the camera frame: its direction d moves by -(omega x d).
    tan = math.tan(elevation)
    return np.array(
        [
            [tan * math.cos(azimuth), tan * math.sin(azimuth), -1.0],
            [-math.sin(azimuth), math.cos(azimuth), 0.0],
        ]
    )


def sighting_jacobian(point: Floats) -> Floats:
    """Return the change of a point's heading per displacement of the point, rad/m, shape (2, 3).

    Args:
        point: Point in the camera frame, m, shape (3,).
    """
    x, y, z = point.tolist()
    level = x * x + y * y
    across, square = math.sqrt(level), level + z * z
    return np.array(
        [
            [-y / level, x / level, 0.0],
            [-x * z / (across * square), -y * z / (across * square), across / square],
        ]
    )


@compiled_once
def line_of_sight(
    lens: Floats, column: float, row: float, rotation: Floats, direction: Floats
) -> tuple[float, float]:
    """Write the line of sight of a pixel in the world frame; return its length and scale.

    Args:
        lens: Width, height and focal length of the camera, px, shape (3,).
        column: Column of the pixel, as in ``sight``.
        row: Row of the pixel, as in ``sight``.
        rotation: Rotation of the camera, shape (3, 3).
        direction: Output: line up to the plane x = 1 m of the camera's frame, shape (3,).

    Returns:
        Length of the line, and the factor by which a pinhole enlarges areas there, which is the
        cosine cubed of the angle off the camera's axis.
    """
    y, z = (lens[0] / 2 - column) / lens[2], (lens[1] / 2 - row) / lens[2]
    square = 1.0 + y * y + z * z
    for i in range(3):
        direction[i] = rotation[i, 0] + rotation[i, 1] * y + rotation[i, 2] * z
    return math.sqrt(square), square**-1.5
