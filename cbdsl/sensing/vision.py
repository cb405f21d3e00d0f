"""Vision: what cameras see in, headings and remembered positions out, channel by channel."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.camera import heading, line_of_sight
from cbdsl.sensing.channels import ChannelFilter, Region
from cbdsl.sensing.kinematics import Frame, Kinematics
from cbdsl.sensing.memory import PositionMemory
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.stereo import Ray, cross_rays

Floats = NDArray[np.float64]

# A hidden thing lies at most this much behind the hand that hides it, m.
_BEHIND_HAND = 0.1
# Fingertips that touch a thing are about a radius from its middle; within this share of it, and
# feeling nothing, they have closed on air.
_INSIDE = 0.75


class SeenHeading(NamedTuple):
    """A heading to a region.

    Attributes:
        angles: azimuth and elevation, rad, shape (2,).
        stamp: number of the image in which the region was seen.
    """

    angles: Floats
    stamp: int


class Sighting(NamedTuple):
    """The line of sight to a region.

    Attributes:
        ray: the line of sight to its centroid, as long as it is to the plane x = 1 m of the
            camera's frame.
        scale: how much the pinhole enlarges areas there, as ``line_of_sight`` has it.
        time: when, s.
        image: number of the image.
    """

    ray: Ray
    scale: float
    time: float
    image: int


class Vision:
    """Sees the wanted channels with every camera.

    Attributes:
        channels: that it looks for.
        headings: those that have been asked for since the newest images, by (camera, channel).
        regions: the regions in the newest images.
        memories: by channel, with two cameras.
        images: how many sets of images have been seen since the start of the episode.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, channels: Iterable[str]
    ) -> None:
        self._cameras: Mapping[str, Camera] = robot.cameras
        self._lenses = {
            name: np.array((each.width, each.height, each.focal_length), dtype=float)
            for name, each in robot.cameras.items()
        }
        self._kinematics = kinematics
        regions = self._settings = robot.vision.regions
        lengths = [each.focal_length for each in robot.cameras.values()]
        self._bounds = np.array((regions.ray_gap, regions.farthest, *lengths), dtype=float)
        self.channels = tuple(dict.fromkeys(channels))
        self._filters = {
            name: ChannelFilter(robot.vision.channels, self.channels, self._settings.least_area)
            for name in robot.cameras
        }
        # Upper arms are thin and seldom in view; what hides things is the wrist and the hand.
        self._wrists = tuple(
            effector.joints[-1] for effector in robot.effectors.values() if effector.tip is not None
        )
        tips = [each.tip.link for each in robot.effectors.values() if each.tip is not None]
        fingers = [[cell.link for cell in hand.values()] for hand in robot.load_cells.values()]
        self._hand_links = (*tips, *(link for hand in fingers for link in hand))
        ends = np.cumsum([len(self._wrists) + len(tips), *map(len, fingers)]).tolist()
        #: By hand, which of the points that may hide things are its fingertips.
        self._fingers = [slice(start, end) for start, end in itertools.pairwise(ends)]
        stereo = len(robot.cameras) == 2
        self.memories = {name: PositionMemory(self._settings) for name in self.channels if stereo}
        self.reset()

    def reset(self) -> None:
        """Forget everything seen."""
        self.headings: dict[tuple[str, str], SeenHeading] = {}
        self.regions: dict[tuple[str, str], Region] = {}
        self.images = 0
        self._sights: dict[tuple[str, str], Sighting] = {}
        self._frames: dict[str, Frame] = {}
        # No line of sight leaves a camera that has not seen anything yet.
        self._eyes: Floats = np.full((len(self._cameras), 3), math.nan)
        self._hands: Floats | None = None
        self._time = self._image_time = 0.0
        self._looking: Collection[str] = ()
        for memory in self.memories.values():
            memory.reset()
        for channel_filter in self._filters.values():
            channel_filter.reset()
        self._expects = self._knows()

    def update(self, observation: Observation) -> None:
        """Take in what the cameras saw, if they saw anything; the kinematics must be up to date."""
        time = observation.time
        for memory in self.memories.values():
            memory.predict(time - self._time, time)
        self._time = time
        if not (observation.images or observation.regions):
            return
        self.images += 1
        self._image_time = time
        self._hands = None
        self.headings.clear()
        self.regions.clear()
        seen = self._seen(observation)
        self._looking = seen.keys()
        # Most of a search shows nothing, with nothing known yet.
        if self._expects or any(seen.values()):
            self._look(seen)
            for channel, memory in self.memories.items():
                self._remember(time, channel, memory)
            self._expects = self._knows()

    def touched(self) -> None:
        """Take everything remembered to stand still, since a hand is in contact."""
        for memory in self.memories.values():
            memory.rest()

    def untouched(self) -> None:
        """Forget what a hand has closed on, since no hand is in contact."""
        # Only what is hidden may be somewhere else than it is remembered.
        if self._hands is None:
            return
        for memory in self.memories.values():
            if memory.position is not None and self._has_closed_on(memory.position, memory.radius):
                memory.reset()

    def heading(self, camera: str, channel: str) -> SeenHeading | None:
        """The heading to what a camera sees, or saw a moment ago, in its newest image.

        A head that turns while it searches overshoots what it sees first at an image's edge, and
        would otherwise search on and never get hold of it.
        """
        sighting = self.headings.get((camera, channel))
        if sighting is None and self._sights and camera in self._looking:
            seen = self._sights.get((camera, channel))
            if seen is not None:
                angles = heading(self._frames[camera].rotation.T.dot(seen.ray.direction))
                sighting = self.headings[camera, channel] = SeenHeading(angles, seen.image)
        return sighting

    def _seen(self, observation: Observation) -> Mapping[str, Sequence[tuple[str, Region]]]:
        """The region of each wanted channel that has one, by camera."""
        by_camera = observation.regions or {
            name: self._filters[name].regions(image) for name, image in observation.images.items()
        }
        if not any(by_camera.values()):
            return dict.fromkeys(by_camera, ())
        least = self._settings.least_area
        return {
            name: [
                (channel, region)
                for channel in self.channels
                if (region := regions.get(channel)) is not None and region.area >= least
            ]
            for name, regions in by_camera.items()
        }

    def _knows(self) -> bool:
        """Whether images tell something even if they show nothing."""
        return (
            bool(self._sights)
            or "motion" in self.channels
            or any(memory.position is not None for memory in self.memories.values())
        )

    def _look(self, seen: Mapping[str, Sequence[tuple[str, Region]]]) -> None:
        self._sights = {
            key: sight
            for key, sight in self._sights.items()
            if self._image_time - sight.time <= self._settings.linger
        }
        for row, (name, camera) in enumerate(self._cameras.items()):
            if name not in seen:
                continue
            frame = self._kinematics.frame(camera.link)
            for channel, region in seen[name]:
                # A turning camera sees everything move, which says nothing about the world.
                if channel == "motion" and self._moved(name, frame):
                    continue
                self.regions[name, channel] = region
                self._sights[name, channel] = self._sighted(name, frame, region)
            self._frames[name] = frame
            self._eyes[row] = frame.position

    def _sighted(self, camera: str, frame: Frame, region: Region) -> Sighting:
        line, lens = np.empty(3), self._lenses[camera]
        length, scale = line_of_sight(lens, region.column, region.row, frame.rotation, line)
        ray = Ray(frame.position, line, length)
        return Sighting(ray, scale, self._image_time, self.images)

    def _moved(self, camera: str, frame: Frame) -> bool:
        """Whether a camera has turned since its last image; also before its first."""
        before = self._frames.get(camera)
        return before is None or not np.allclose(frame.rotation, before.rotation, atol=1e-3)

    def _remember(self, time: float, channel: str, memory: PositionMemory) -> None:
        sighting = self._sighting(channel)
        if sighting is not None:
            position, sizes = sighting
            if memory.looks_smaller(sizes) and not self._hidden_by_hand(position):
                memory.forget_size()
            if memory.see(time, position, sizes):
                return
        explained = memory.position is not None and self._hidden_by_hand(memory.position)
        memory.miss(time, explained=explained)

    def _has_closed_on(self, position: Floats, radius: float) -> bool:
        """Whether all fingertips of a hand were inside of a ball when the cameras last looked."""
        assert self._hands is not None
        return any(
            _are_within(self._hands[fingers], position, _INSIDE * radius)
            for fingers in self._fingers
        )

    def _sighting(self, channel: str) -> tuple[Floats, Sequence[float]] | None:
        """A believable position and the apparent sizes, m^2, or ``None``."""
        sights, areas = [], []
        for name in self._cameras:
            region = self.regions.get((name, channel))
            if region is None or region.clipped:
                return None
            sights.append(self._sights[name, channel])
            areas.append(region.area)
        left, right = sights
        position, sizes = np.empty(3), np.array((areas[0] * left.scale, areas[1] * right.scale))
        if not _locate(
            left.ray.origin, left.ray.direction, left.ray.length,
            right.ray.origin, right.ray.direction, right.ray.length,
            self._bounds, position, sizes,
        ):  # fmt: skip
            return None
        return position, sizes.tolist()

    def _hidden_by_hand(self, position: Floats) -> bool:
        """Whether a wrist, palm or fingertip is near some camera's line of sight to a position."""
        if self._hands is None:
            self._hands = self._kinematics.origins(self._wrists, self._hand_links)
        return _is_beside(self._hands, self._eyes, position, self._settings.hand_radius)


@compiled_once
def _locate(
    left: Floats,
    left_direction: Floats,
    left_length: float,
    right: Floats,
    right_direction: Floats,
    right_length: float,
    bounds: Floats,
    position: Floats,
    sizes: Floats,
) -> bool:
    """Triangulate a region's position, m, shape (3,), and its size as each camera sees it, m^2.

    Args:
        left, right: where the cameras are, m, with the directions of their lines of sight and the
            lengths of these.
        bounds: largest gap between the lines of sight and largest distance, m, then the cameras'
            focal lengths, px, shape (4,).
        position: becomes the position.
        sizes: the region's area in each image, px, straight ahead; become its sizes, shape (2,).

    Returns:
        Whether the lines of sight meet within the bounds.
    """
    gap = cross_rays(
        left, left_direction, left_length, right, right_direction, right_length, position
    )
    if not gap <= bounds[0]:
        return False
    for eye in range(2):
        origin, square = left if eye == 0 else right, 0.0
        for i in range(3):
            square += (position[i] - origin[i]) ** 2
        if square > bounds[1] * bounds[1]:
            return False
        sizes[eye] *= square / bounds[2 + eye] ** 2
    return True


@compiled_once
def _are_within(points: Floats, center: Floats, radius: float) -> bool:
    """Whether all points, shape (n, 3), are nearer to a center, shape (3,), than a radius, m."""
    for point in points:
        x, y, z = point[0] - center[0], point[1] - center[1], point[2] - center[2]
        if x * x + y * y + z * z >= radius * radius:
            return False
    return True


@compiled_once
def _is_beside(points: Floats, eyes: Floats, position: Floats, radius: float) -> bool:
    """Whether one of some points, shape (n, 3), is near the line of sight from one of the eyes.

    Args:
        points: m, shape (n, 3).
        eyes: m, shape (k, 3).
        position: what they look at, m, shape (3,).
        radius: how near, m.
    """
    for eye in eyes:
        line = position - eye
        distance = math.sqrt(line[0] ** 2 + line[1] ** 2 + line[2] ** 2)
        for point in points:
            x, y, z = point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]
            along = (x * line[0] + y * line[1] + z * line[2]) / distance
            across = x * x + y * y + z * z - along * along
            if across < radius * radius and 0 < along < distance + _BEHIND_HAND:
                return True
    return False
