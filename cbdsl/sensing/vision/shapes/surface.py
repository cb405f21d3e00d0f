"""Level surfaces that fill images, located by their outlines in two images.

A surface that fills an image has no centre, and its uniform colour offers only the outline to
match. A sweep over level planes finds the height at which the outlines in both images coincide
(plane sweep stereo, Collins 1996). An outline along the baseline matches at any height and gives no
information.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.kinematics.kinematics import Frame
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.channels import Extent
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import Resource, SurfacePoint
from cbdsl.types.source_record import sources_of

# Nearest and farthest plane below the cameras, and step between planes, m: an outline's image moves
# by at most a pixel a step.
_NEAREST, _FARTHEST, _STEP = 0.3, 1.6, 0.01
_FINE = 0.001
# Distance between the points of an outline, and least distance of outliers, such as points of an
# occluding object, px.
_SPACING, _OUTLIER = 4.0, 3.0
# Least number of matched points of the outline; largest mean squared distance, px^2; largest
# distance of any plane that matches at least half as well, m.
_LEAST_POINTS, _MISFIT, _AMBIGUOUS = 20, 1.5, 0.03
# Largest distance between heights of the same surface, m.
_SAME = 0.03
# Number of sightings that the height is averaged over.
_SIGHTINGS = 10


class SurfaceView(NamedTuple):
    """Surface in the image of one camera."""

    camera: Camera
    frame: Frame
    extent: Extent


class LevelSurface:
    """Level surface that both cameras have seen.

    Attributes:
        height: Height, m, world frame, or ``None`` while undefined.
        points: Points on its last visible part, m, world frame, shape (k, 3).
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the surface."""
        self.height: float | None = None
        self.points: Floats = np.empty((0, 3))
        self._sightings = 0

    def see(self, left: SurfaceView, right: SurfaceView) -> None:
        """Update height and points from the views of both cameras."""
        # A static surface needs only a limited number of measurements.
        settled = self._sightings >= _SIGHTINGS
        height = None if settled else find_height(left, right)
        if height is not None:
            self._correct(height)
        if self.height is not None and left.extent.cover:
            self.points = _on_level(left, np.array(left.extent.cover), self.height)

    def _correct(self, height: float) -> None:
        if self.height is None or abs(height - self.height) > _SAME:
            self.height, self._sightings = height, 1
            return
        self._sightings += 1
        self.height += (height - self.height) / self._sightings


class SurfaceSampler:
    """Sampler of points that are spread evenly over the image of a surface."""

    def __init__(self, surface: LevelSurface, rng: np.random.Generator) -> None:
        self._surface, self._rng = surface, rng

    def draw(self) -> Floats | None:
        """Return the next point, m, shape (3,), or ``None`` while there is none."""
        points = self._surface.points
        return self._rng.choice(points) if len(points) else None


def find_height(left: SurfaceView, right: SurfaceView) -> float | None:
    """Return the height of the level plane that fits both outlines, m, ``None`` unless unique."""
    points, segments = _sampled(left.extent.outline), np.array(right.extent.outline)
    if len(points) < _LEAST_POINTS or not len(segments):
        return None
    eye = min(left.frame.position[2], right.frame.position[2])
    coarse = np.arange(eye - _NEAREST, eye - _FARTHEST, -_STEP)
    costs = _misfits(left, right, points, segments, coarse)
    best = int(np.argmin(costs))
    alike = coarse[costs < max(2 * costs[best], _MISFIT)]
    if costs[best] > _MISFIT or np.abs(alike - coarse[best]).max() > _AMBIGUOUS:
        return None
    fine = coarse[best] + np.arange(-_STEP, _STEP, _FINE)
    return float(fine[np.argmin(_misfits(left, right, points, segments, fine))])


def _sampled(outline: tuple[tuple[float, float, float, float], ...]) -> Floats:
    """Return points along the segments of an outline, px, shape (k, 2)."""
    points = [np.empty((0, 2))]
    for segment in outline:
        ends = np.array(segment).reshape(2, 2)
        count = max(2, round(math.dist(*ends) / _SPACING))
        points.append(np.linspace(ends[0], ends[1], count))
    return np.concatenate(points)


def _lines(view: SurfaceView, points: Floats) -> Floats:
    """Return lines of sight of pixels, world frame, shape (k, 3)."""
    camera = view.camera
    middle = np.array((camera.width, camera.height)) / 2
    slopes = (middle - points) / camera.focal_length
    lines: Floats = np.column_stack([np.ones(len(slopes)), slopes]).dot(view.frame.rotation.T)
    return lines


def _on_level(view: SurfaceView, points: Floats, height: float) -> Floats:
    """Return the points at which downward lines of sight meet a level plane, m, shape (k, 3)."""
    lines = _lines(view, points)
    lines = lines[lines[:, 2] < -1e-3]
    depth = (height - view.frame.position[2]) / lines[:, 2]
    met: Floats = view.frame.position + depth[:, None] * lines
    return met


def _misfits(
    left: SurfaceView, right: SurfaceView, points: Floats, segments: Floats, heights: Floats
) -> Floats:
    camera, costs = right.camera, np.empty(len(heights))
    lens = np.array((camera.focal_length, camera.width, camera.height), dtype=float)
    _sweep(
        left.frame.position, _lines(left, points), right.frame.position, right.frame.rotation,
        lens, segments, heights, costs,
    )  # fmt: skip
    return costs


@compiled_once
def _sweep(
    eye: Floats,
    lines: Floats,
    other_eye: Floats,
    rotation: Floats,
    lens: Floats,
    segments: Floats,
    heights: Floats,
    costs: Floats,
) -> None:
    """Compute the mean squared distance of two outlines for each of several level planes.

    Args:
        eye: Position of the camera that sees the first outline, m, shape (3,).
        lines: Lines of sight to the points of this outline, shape (n, 3).
        other_eye: Position of the other camera, m, shape (3,).
        rotation: Rotation of the other camera, shape (3, 3).
        lens: Focal length, width and height of the other camera, px, shape (3,).
        segments: Segments of the outline that the other camera sees, px, shape (k, 4).
        heights: Heights of the planes, m, shape (m,).
        costs: Output: mean squared distances, px^2, infinite if too few points match, shape (m,).
    """
    offset, point = np.empty(3), np.empty(3)
    for which in range(len(heights)):
        total, count = 0.0, 0
        for line in lines:
            if line[2] > -1e-3:
                continue
            depth = (heights[which] - eye[2]) / line[2]
            for i in range(3):
                offset[i] = eye[i] + depth * line[i] - other_eye[i]
            for i in range(3):
                point[i] = (
                    rotation[0, i] * offset[0]
                    + rotation[1, i] * offset[1]
                    + rotation[2, i] * offset[2]
                )
            if point[0] < 0.05:
                continue
            column = 0.5 * lens[1] - lens[0] * point[1] / point[0]
            row = 0.5 * lens[2] - lens[0] * point[2] / point[0]
            # A point at the border may match a part of the outline beyond it.
            if not (3.0 < column < lens[1] - 3.0 and 3.0 < row < lens[2] - 3.0):
                continue
            nearest = _OUTLIER * _OUTLIER
            for segment in segments:
                across, down = segment[2] - segment[0], segment[3] - segment[1]
                share = (column - segment[0]) * across + (row - segment[1]) * down
                share = min(max(share / (across * across + down * down), 0.0), 1.0)
                x = column - segment[0] - share * across
                y = row - segment[1] - share * down
                nearest = min(nearest, x * x + y * y)
            total += nearest
            count += 1
        costs[which] = total / count if count >= _LEAST_POINTS else math.inf


class Surfaces:
    """Static surfaces by channel, which are remembered until the episode ends.

    Args:
        robot: Robot document with a stereo pair.
        vision: Regions in the images of the cameras.
    """

    def __init__(self, robot: RobotDocument, vision: Vision) -> None:
        self._robot, self._vision = robot, vision
        self.by_channel: dict[str, LevelSurface] = {}

    def follow(self, resources: Iterable[Resource]) -> None:
        """Follow the surfaces of more resources from now on."""
        for source in sources_of(resources, SurfacePoint):
            self.by_channel.setdefault(source.channel, LevelSurface())

    def reset(self) -> None:
        """Forget the previous episode."""
        for surface in self.by_channel.values():
            surface.reset()

    def update(self, observation: Observation) -> None:
        """Update the surfaces from the newest images; vision must be up to date."""
        if not (observation.images or observation.regions):
            return
        for channel, surface in self.by_channel.items():
            views = [self._view(camera, channel) for camera in self._robot.main_cameras]
            left, right = views
            if left is not None and right is not None:
                surface.see(left, right)

    def _view(self, name: str, channel: str) -> SurfaceView | None:
        regions = self._vision.seen.get(name, {}).get(channel, ())
        extent = next((each.extent for each in regions if each.extent is not None), None)
        if extent is None:
            return None
        camera = self._robot.cameras[name]
        return SurfaceView(camera, self._vision.field.frames[name], extent)
