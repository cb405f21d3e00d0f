"""Vision: headings and remembered positions from camera images, channel by channel."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.channels import ChannelFilter, Region, Regions
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.association.stereo import Ray, triangulate
from cbdsl.sensing.vision.memory.instances import Instances
from cbdsl.sensing.vision.memory.memory import PositionMemory
from cbdsl.sensing.vision.regions.camera import heading, line_of_sight
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView

# Time for which postures are kept, s; images must arrive with less delay.
_KEPT = 1.5
# Tolerance of times for rounding, s.
_SLACK = 1e-6


class PostureHistory:
    """Joint positions of the last ticks, back to the newest requested image, or 1.5 s."""

    def __init__(self) -> None:
        self._ticks: deque[tuple[float, Floats]] = deque()

    def reset(self) -> None:
        """Forget the episode before."""
        self._ticks.clear()

    def note(self, time: float, positions: Floats) -> None:
        """Add a tick's time, s, and joint positions, shape (n,), which must not be overwritten."""
        self._ticks.append((time, positions))
        if self._ticks[0][0] < time - _KEPT:
            self._ticks.popleft()

    def at(self, time: float) -> Floats:
        """Return joint positions, shape (n,), of the last tick up to a time, s, or the oldest."""
        ticks = self._ticks
        while len(ticks) > 1 and ticks[1][0] <= time + _SLACK:
            ticks.popleft()
        return ticks[0][1]


# Largest rotation of a still camera between images, rad: a 25th of a pixel, so that no edge of a
# resting object moves by enough pixels to be a region.
_STILL = 1e-4


class SeenHeading(NamedTuple):
    """Heading to a region.

    Attributes:
        angles: Azimuth and elevation, rad, shape (2,).
        stamp: Number of the image in which the region was seen.
    """

    angles: Floats
    stamp: int


class Vision:
    """Regions, headings and memories of the requested channels in all cameras.

    Attributes:
        channels: Channels to look for.
        instances: Objects of each channel.
        field: Field of view of the cameras.
        headings: Cached headings since the newest images, by camera, channel and number of the
            object.
        all_memories: Memories of the objects of all channels, with a stereo pair.
        images: Number of sets of images since the start of the episode.
        seen: Regions in the newest images, by camera and channel, the largest first.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics) -> None:
        # The main cameras come first; their number is that of the rows of ``Instances``.
        self._cameras: Mapping[str, Camera] = {**robot.main_cameras, **robot.cameras}
        self._main = len(robot.main_cameras)
        self._lenses = {
            name: np.array((each.width, each.height, each.focal_length), dtype=float)
            for name, each in self._cameras.items()
        }
        self._links = tuple([camera.link for camera in self._cameras.values()])
        self._kinematics = kinematics
        self._settings, self._divided = robot.vision.regions, robot.vision.channels
        self.field = FieldOfView(robot, kinematics)
        self._history = PostureHistory()
        self._rows = {name: row for row, name in enumerate(self._cameras)}
        self.channels: tuple[str, ...] = ()
        self.instances: dict[str, Instances] = {}
        # Sightings of all cameras in the newest images, by channel and number of the object.
        self._sightings: dict[str, list[dict[int, Sighting]]] = {}
        self._filters: dict[str, ChannelFilter] = {}
        self.all_memories: tuple[PositionMemory, ...] = ()
        self.reset()

    def look_for(self, channels: Iterable[str]) -> None:
        """Look for more channels from now on; memories of the others stay."""
        more = [each for each in dict.fromkeys(channels) if each not in self.instances]
        if self._filters and not more:
            return
        self.channels = (*self.channels, *more)
        self._filters = {
            name: ChannelFilter(self._divided, self.channels, self._settings.least_area)
            for name in self._cameras
        }
        for name in more:
            own = self.instances[name] = Instances(self._settings, self.field, self._main)
            others = range(self._main, len(self._cameras))
            self._sightings[name] = [*own.sightings, *({} for _ in others)]
        self.all_memories = tuple(m for each in self.instances.values() for m in each.memories)

    def reset(self) -> None:
        """Forget everything seen."""
        self.headings: dict[tuple[str, str, int], SeenHeading] = {}
        self.images = 0
        self._lingering: dict[tuple[str, str, int], Sighting] = {}
        self._time = self._image_time = self._exposed = 0.0
        self._axes: Mapping[str, Floats] = {}
        self._history.reset()
        self._looking: Collection[str] = ()
        self.seen: Mapping[str, Mapping[str, Sequence[Region]]] = {}
        self.field.reset()
        for channel, instances in self.instances.items():
            instances.reset()
            for alone in self._sightings[channel][self._main :]:
                alone.clear()
        for channel_filter in self._filters.values():
            channel_filter.reset()
        self._has_state = self._has_any_state()

    @property
    def memories(self) -> Mapping[str, PositionMemory]:
        """Memory of the object attended to, by channel, with a stereo pair."""
        return {
            name: each.memories[each.attended]
            for name, each in self.instances.items()
            if each.memories
        }

    def number(self, channel: str, instance: str) -> int | None:
        """Return an instance's number in a channel, ``None`` without one; see ``Instances``."""
        return self.instances[channel].number(instance)

    def memory(self, channel: str, number: int | None = None) -> PositionMemory | None:
        """Return the memory of an object, by default of the one attended to."""
        instances = self.instances.get(channel)
        if instances is None or not instances.memories:
            return None
        return instances.memories[instances.attended if number is None else number]

    def region(self, camera: str, channel: str, number: int | None = None) -> Region | None:
        """Return an object's region in a camera's newest image, by default of the attended one."""
        seen = self._sightings[channel][self._rows[camera]]
        sighting = seen.get(self.instances[channel].attended if number is None else number)
        return None if sighting is None else sighting.region

    def meeting(self, channel: str) -> Floats | None:
        """Return where the lines of sight to a channel's object meet now, m, world frame.

        Unlike the remembered position, it is ``None`` if a camera does not see the object, and
        inaccurate if a part of the object is hidden. It is also ``None`` if the lines miss each
        other.
        """
        instances = self.instances[channel]
        seen = [each.get(instances.attended) for each in instances.sightings]
        rays = [each.ray for each in seen if each is not None]
        if len(rays) != 2 or len(seen) != 2:
            return None
        crossing = triangulate(*rays)
        near = crossing is not None and crossing.gap <= self._settings.ray_gap
        return crossing.position if crossing is not None and near else None

    def update(self, observation: Observation) -> None:
        """Update from an observation and its images, if any; kinematics must be up to date."""
        time = observation.time
        for memory in self.all_memories:
            if memory.position is not None:
                memory.predict(time - self._time, time)
        self._time = time
        self._history.note(time, observation.positions.copy())
        if not (observation.images or observation.regions):
            return
        self.images += 1
        self._image_time = time
        self._exposed = time if observation.exposed is None else observation.exposed
        self.field.renew(self._history.at(self._exposed))
        self.headings.clear()
        seen = self.seen = self._seen(observation)
        self._looking = seen.keys()
        # Most images of a search show no region, and no object is known yet.
        if self._has_state or any(seen.values()):
            self._look(seen)
            self._has_state = self._has_any_state()

    def carry(self, carried: Iterable[tuple[PositionMemory, Floats]]) -> None:
        """Displace remembered objects, m, shape (3,) each."""
        for memory, displacement in carried:
            memory.carry(displacement)

    def touched(self) -> None:
        """Set the velocity of all remembered objects to zero, because a hand is in contact."""
        for memory in self.all_memories:
            memory.rest()

    def untouched(self) -> None:
        """Forget objects at which a hand has closed, because no hand is in contact."""
        for memory in self.all_memories:
            if memory.position is not None and self.field.hands_have_closed_on(
                memory.position, memory.radius
            ):
                memory.reset()

    def heading(self, camera: str, channel: str, number: int | None = None) -> SeenHeading | None:
        """Return the heading to an object that a camera sees or saw a moment ago.

        A head that turns during a search overshoots an object that appears at an image's edge.
        Without lingering headings, it would search on and never fixate the object.

        Args:
            camera: Name of the camera.
            channel: Channel of the object.
            number: Number of the object; of the attended one by default.
        """
        key = camera, channel, self.instances[channel].attended if number is None else number
        seen_heading = self.headings.get(key)
        if seen_heading is None and self._lingering and camera in self._looking:
            seen = self._lingering.get(key)
            if seen is not None:
                # Heading from the current camera axes, because the head may have turned since the
                # image.
                angles = heading(self._axes[camera].T.dot(seen.ray.direction))
                seen_heading = self.headings[key] = SeenHeading(angles, seen.image)
        return seen_heading

    def _seen(self, observation: Observation) -> Mapping[str, Mapping[str, Sequence[Region]]]:
        """Return the regions of each requested channel that has any, by camera."""
        by_camera = observation.regions or {
            name: self._filters[name].regions(image) for name, image in observation.images.items()
        }
        return {name: self._large(regions) for name, regions in by_camera.items()}

    def _large(self, regions: Mapping[str, Regions]) -> Mapping[str, Sequence[Region]]:
        """Return the sufficiently large regions of a camera, by requested channel."""
        least, large = self._settings.least_area, {}
        for channel in self.channels:
            several = regions.get(channel)
            if several and several[0].area >= least:
                all_are = several[-1].area >= least
                large[channel] = several if all_are else [e for e in several if e.area >= least]
        return large

    def _has_any_state(self) -> bool:
        """Return whether even images without regions change the state of vision."""
        return (
            bool(self._lingering)
            or "motion" in self.channels
            or any(memory.position is not None for memory in self.all_memories)
        )

    def _look(self, seen: Mapping[str, Mapping[str, Sequence[Region]]]) -> None:
        by_channel: dict[str, list[list[Sighting]]] = {
            channel: [[] for _ in self._cameras] for channel in self.channels
        }
        frames, turned = self.field.placed(self._links), set[str]()
        placed = zip(self._cameras, self._kinematics.placed(self._links), strict=True)
        self._axes = {name: frame.rotation for name, frame in placed}
        for row, (name, frame) in enumerate(zip(self._cameras, frames, strict=True)):
            if name not in seen:
                continue
            if "motion" in self.channels and self._moved(name, frame):
                turned.add(name)
            for channel, regions in seen[name].items():
                # A turning camera sees everything move, so its motion channel is ignored.
                if channel == "motion":
                    if name in turned:
                        continue
                    # One moving object changes the image at its previous and at its current place.
                    regions = regions[:1]
                by_channel[channel][row] = [
                    self._sighted(name, frame, region) for region in regions
                ]
            self.field.place(name, frame)
        for channel, sightings in by_channel.items():
            instances, others = self.instances[channel], _others(by_channel, channel, self._main)
            instances.look(self._image_time, self._exposed, sightings[: self._main], others)
            for row in range(self._main, len(self._cameras)):
                self._look_alone(instances, self._sightings[channel][row], sightings[row])
        self._linger(turned)

    @staticmethod
    def _look_alone(
        instances: Instances, seen: dict[int, Sighting], sightings: Sequence[Sighting]
    ) -> None:
        """Update an additional camera's sightings, by the objects that the pair remembers.

        Without any, its largest region is the object attended to.
        """
        seen.clear()
        if instances.known:
            instances.associate(seen, sightings)
        elif sightings:
            seen[instances.attended] = sightings[0]

    def _linger(self, turned: Collection[str]) -> None:
        """Keep the sightings of the newest images and of the linger time before.

        A moving object is kept while a camera turns, because that camera cannot detect motion.
        """
        for channel, by_camera in self._sightings.items():
            for camera, sightings in zip(self._cameras, by_camera, strict=True):
                for number, sighting in sightings.items():
                    self._lingering[camera, channel, number] = sighting
        now, linger = self._image_time, self._settings.linger
        for key, sighting in self._lingering.items() if turned else ():
            if key[1] == "motion" and key[0] in turned:
                self._lingering[key] = sighting._replace(time=now)
        if any([now - sighting.time > linger for sighting in self._lingering.values()]):
            self._lingering = {
                key: sighting
                for key, sighting in self._lingering.items()
                if now - sighting.time <= linger
            }

    def _sighted(self, camera: str, frame: Frame, region: Region) -> Sighting:
        line, lens = np.empty(3), self._lenses[camera]
        length, scale = line_of_sight(lens, region.column, region.row, frame.rotation, line)
        ray = Ray(frame.position, line, length)
        focal_length = self._cameras[camera].focal_length
        return Sighting(region, ray, scale, focal_length, self._image_time, self.images)

    def _moved(self, camera: str, frame: Frame) -> bool:
        """Return whether a camera has turned since its last image, or has none."""
        before = self.field.frames.get(camera)
        return before is None or not np.allclose(frame.rotation, before.rotation, atol=_STILL)


def _others(
    by_channel: Mapping[str, Sequence[Sequence[Sighting]]], channel: str, cameras: int
) -> list[list[Sighting]]:
    """Return the sightings of all other channels' objects, by camera; motion hides nothing."""
    names = [name for name in by_channel if name not in (channel, "motion")]
    return [[each for name in names for each in by_channel[name][row]] for row in range(cameras)]
