"""Pair of fixed cameras that look at a place, for robots without cameras of their own."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

# Cameras seen from the place that they look at: in front of the robot, and above, m.
_AHEAD, _ASIDE, _ABOVE = 0.75, 0.2, 0.95
_WIDTH, _HEIGHT, _FOCAL_LENGTH = 640, 480, 837.0


class CameraPlace(NamedTuple):
    """Pose of a camera.

    Attributes:
        position: Position, m, world frame.
        axes: Rotation by rows; its columns look forward, to the left and up.
    """

    position: list[float]
    axes: list[float]


class CameraPair(NamedTuple):
    """Left and right camera.

    Attributes:
        places: Pose of each camera by name.
        width, height: Size of an image, px.
        focal_length: Focal length, px.
    """

    places: dict[str, CameraPlace]
    width: int = _WIDTH
    height: int = _HEIGHT
    focal_length: float = _FOCAL_LENGTH

    @property
    def vertical_angle(self) -> float:
        """Vertical angle of view, deg."""
        return math.degrees(2 * math.atan(self.height / 2 / self.focal_length))


def looking_at(place: tuple[float, float, float]) -> CameraPair:
    """Return a pair of cameras that face a robot, which faces along x.

    Args:
        place: Middle of the view, m, world frame.
    """
    target = np.array(place)
    places = {}
    # The viewer looks along -x: its left is at negative y.
    for name, side in (("left", -_ASIDE), ("right", _ASIDE)):
        position = target + np.array([_AHEAD, side, _ABOVE])
        forward = (target - position) / np.linalg.norm(target - position)
        left = np.cross([0.0, 0.0, 1.0], forward)
        left /= np.linalg.norm(left)
        axes = np.column_stack([forward, left, np.cross(forward, left)])
        places[name] = CameraPlace(position.tolist(), axes.ravel().tolist())
    return CameraPair(places)
