"""Vision: what cameras see in, headings and remembered positions out, channel by channel."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.robot.camera import focal_scale, heading, sight
from cbdsl.robot.channels import ChannelFilter, Region
from cbdsl.robot.compiled import compiled_once
from cbdsl.robot.kinematics import Frame, Kinematics
from cbdsl.robot.memory import PositionMemory
from cbdsl.robot.observation import Observation
from cbdsl.robot.stereo import Ray, triangulate

Floats = NDArray[np.float64]

# A hidden thing lies at most this much behind the hand that hides it, m.
_BEHIND_HAND = 0.1


class _Sight(NamedTuple):
    """Where a region was seen.

    Attributes:
        line: of sight to its centroid, in the camera's frame, with x = 1, shape (3,).
        direction: the same in the world frame, shape (3,).
        time: when, s.
        image: number of the image.
    """

    line: Floats
    direction: Floats
    time: float
    image: int


class Vision:
    """Sees the wanted channels with every camera.

    Attributes:
        headings: rad, shape (2,), by (camera, channel); absent where there is no region, nor has
            been one a moment ago.
        stamps: the number of the image in which each heading's region was seen.
        regions: the regions in the newest images.
        memories: by channel, with two cameras.
        images: how many sets of images have been seen since the start of the episode.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, channels: Iterable[str]
    ) -> None:
        self._cameras: Mapping[str, Camera] = robot.cameras
        self._kinematics = kinematics
        self._settings = robot.vision.regions
        self._channels = tuple(dict.fromkeys(channels))
        self._filters = {
            name: ChannelFilter(robot.vision.channels, self._channels, self._settings.least_area)
            for name in robot.cameras
        }
        # Upper arms are thin and seldom in view; what hides things is the wrist and the hand.
        self._wrists = tuple(
            effector.joints[-1] for effector in robot.effectors.values() if effector.tip is not None
        )
        tips = [each.tip.link for each in robot.effectors.values() if each.tip is not None]
        fingers = [cell for hand in robot.load_cells.values() for cell in hand.values()]
        self._hand_links = (*tips, *(cell.link for cell in fingers))
        stereo = len(robot.cameras) == 2
        self.memories = {name: PositionMemory(self._settings) for name in self._channels if stereo}
        self.reset()

    def reset(self) -> None:
        """Forget everything seen."""
        self.headings: dict[tuple[str, str], Floats] = {}
        self.stamps: dict[tuple[str, str], int] = {}
        self.regions: dict[tuple[str, str], Region] = {}
        self.images = 0
        self._sights: dict[tuple[str, str], _Sight] = {}
        self._frames: dict[str, Frame] = {}
        self._hands: Floats | None = None
        self._time = 0.0
        for memory in self.memories.values():
            memory.reset()
        for channel_filter in self._filters.values():
            channel_filter.reset()

    def update(self, observation: Observation) -> None:
        """Take in what the cameras saw, if they saw anything; the kinematics must be up to date."""
        time = observation.time
        for memory in self.memories.values():
            memory.predict(time - self._time, time)
        self._time = time
        if not (observation.images or observation.regions):
            return
        self.images += 1
        self._hands = None
        self._look(self._seen(observation))
        for channel, memory in self.memories.items():
            self._remember(time, channel, memory)

    def touched(self) -> None:
        """Take everything remembered to stand still, since a hand is in contact."""
        for memory in self.memories.values():
            memory.rest()

    def _seen(self, observation: Observation) -> Mapping[str, Mapping[str, Region]]:
        """The region of each wanted channel that has one, by camera."""
        seen: dict[str, Mapping[str, Region]] = {
            name: self._filters[name].regions(image) for name, image in observation.images.items()
        }
        for name, regions in observation.regions.items():
            seen[name] = {
                channel: region
                for channel, region in regions.items()
                if channel in self._channels and region.area >= self._settings.least_area
            }
        return seen

    def _look(self, seen: Mapping[str, Mapping[str, Region]]) -> None:
        self.headings.clear()
        self.regions.clear()
        for name, regions in seen.items():
            camera = self._cameras[name]
            frame = self._kinematics.frame(camera.link)
            moved = "motion" in regions and self._moved(name, frame)
            self._frames[name] = frame
            for channel, region in regions.items():
                # A turning camera sees everything move, which says nothing about the world.
                if channel == "motion" and moved:
                    continue
                self.regions[name, channel] = region
                line = sight(camera, region.column, region.row)
                direction = frame.rotation.dot(line)
                self._sights[name, channel] = _Sight(line, direction, self._time, self.images)
            self._head_for(name, frame)

    def _moved(self, camera: str, frame: Frame) -> bool:
        """Whether a camera has turned since its last image; also before its first."""
        before = self._frames.get(camera)
        return before is None or not np.allclose(frame.rotation, before.rotation, atol=1e-3)

    def _head_for(self, camera: str, frame: Frame) -> None:
        """Headings to all that a camera sees, or saw a moment ago.

        A head that turns while it searches overshoots what it sees first at an image's edge, and
        would otherwise search on and never get hold of it.
        """
        for channel in self._channels:
            seen = self._sights.get((camera, channel))
            if seen is not None and self._time - seen.time <= self._settings.linger:
                self.headings[camera, channel] = heading(frame.rotation.T.dot(seen.direction))
                self.stamps[camera, channel] = seen.image

    def _remember(self, time: float, channel: str, memory: PositionMemory) -> None:
        sighting = self._sighting(channel)
        if sighting is not None:
            position, sizes = sighting
            if not self._hidden_by_hand(position):
                memory.forget_size()
            if memory.see(time, position, sizes):
                return
        explained = memory.position is not None and self._hidden_by_hand(memory.position)
        memory.miss(time, explained=explained)

    def _sighting(self, channel: str) -> tuple[Floats, Floats] | None:
        """A believable position and the apparent sizes, m^2, or ``None``."""
        regions, rays = [], []
        for name in self._cameras:
            region = self.regions.get((name, channel))
            if region is None or region.clipped:
                return None
            regions.append(region)
            seen = self._sights[name, channel]
            length = math.sqrt(seen.line.dot(seen.line))
            rays.append(Ray(self._frames[name].position, seen.direction / length))
        crossing = triangulate(rays[0], rays[1])
        if crossing is None or crossing.gap > self._settings.ray_gap:
            return None
        sizes = []
        for (name, camera), region, ray in zip(self._cameras.items(), regions, rays, strict=True):
            distance = math.dist(crossing.position, ray.origin)
            if distance > self._settings.farthest:
                return None
            scale = focal_scale(camera, self._sights[name, channel].line)
            sizes.append(region.area * scale * (distance / camera.focal_length) ** 2)
        return crossing.position, np.array(sizes)

    def _hidden_by_hand(self, position: Floats) -> bool:
        """Whether a wrist, palm or fingertip is near some camera's line of sight to a position."""
        if self._hands is None:
            self._hands = self._kinematics.origins(self._wrists, self._hand_links)
        radius = self._settings.hand_radius
        return any(
            _is_beside(self._hands, frame.position, position, radius)
            for frame in self._frames.values()
        )


@compiled_once
def _is_beside(points: Floats, eye: Floats, position: Floats, radius: float) -> bool:
    """Whether one of some points, shape (n, 3), is near the line of sight from an eye, m."""
    line = position - eye
    distance = math.sqrt(line[0] ** 2 + line[1] ** 2 + line[2] ** 2)
    for point in points:
        x, y, z = point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]
        along = (x * line[0] + y * line[1] + z * line[2]) / distance
        across = x * x + y * y + z * z - along * along
        if across < radius * radius and 0 < along < distance + _BEHIND_HAND:
            return True
    return False
