"""Signals of blobs: velocity, extent, orientation in images; velocity, volume, number in space."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.channels import Region
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.vision.regions.camera import sight, sighting_jacobian
from cbdsl.sensing.vision.signals.visual_signals import VisualSignals
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import (
    BlobSignal,
    ConstellationSignal,
    InstanceCount,
    Resource,
    StereoOffset,
    StereoSignal,
)
from cbdsl.types.source_record import sources_of

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


class Constellation(NamedTuple):
    """Relative scales of two blobs, and their relative orientation (Section 7.3.1, Fig 7.15).

    Their relative position is not included, as in the dissertation.

    Attributes:
        longer: Ratio of du of the first blob to that of the second.
        shorter: Ratio of dv of the first blob to that of the second.
        turn: Angle psi of the first blob's longer axis from that of the second, rad, above -pi/2 up
            to pi/2; 0 if either blob is round and so has no longer axis.
    """

    longer: float
    shorter: float
    turn: float

    @property
    def value(self) -> Floats:
        """Longer and shorter ratio and turn, shape (3,)."""
        return np.array(self)


def constellation_of(first: Blob, second: Blob) -> Constellation:
    """Return the constellation of two blobs."""
    longer, shorter = (first.extent / second.extent).tolist()
    axes = first.orientation, second.orientation
    turn = 0.0 if axes[0] is None or axes[1] is None else half_turn(axes[0] - axes[1])
    return Constellation(longer, shorter, turn)


def half_turn(angle: float) -> float:
    """Return an angle modulo half a turn, rad, above -pi/2 up to pi/2."""
    return angle - math.pi * math.ceil(angle / math.pi - 0.5)


class _Motion(NamedTuple):
    """Heading in the newest image, and its rate since the previous image, rad/s, if seen there."""

    image: int
    time: float
    angles: Floats
    rate: Floats | None


class BlobSignals:
    """Reader of blob signals, whose Jacobians are unknown.

    Args:
        robot: Robot document with the cameras.
        vision: Regions, headings and memories of the cameras.
        sight: Visual signals, which know the held objects.
    """

    def __init__(self, robot: RobotDocument, vision: Vision, sight: VisualSignals) -> None:
        self._robot, self._vision, self._sight = robot, vision, sight
        self._followed: set[tuple[str, str, str]] = set()
        self.reset()

    def follow(self, resources: Iterable[Resource]) -> None:
        """Follow the blobs of more resources from now on."""
        self._followed |= {
            (source.camera, source.channel, source.instance)
            for source in sources_of(resources, BlobSignal)
            if source.part == "velocity"
        }

    def reset(self) -> None:
        """Forget the episode before."""
        self._motions: dict[tuple[str, str, int], _Motion] = {}
        self._joint_velocities: Floats = np.zeros(0)

    def update(self, observation: Observation) -> None:
        """Update heading rates from the newest images; vision must be up to date."""
        self._joint_velocities = observation.velocities
        if not (observation.images or observation.regions):
            return
        # Instances with two different names may be the same object.
        things = {
            (camera, channel, number)
            for camera, channel, instance in self._followed
            if (number := self._vision.number(channel, instance)) is not None
        }
        for thing in things:
            self._follow(thing, observation.time)

    def blob(self, source: BlobSignal) -> Reading | None:
        """Return a part of the blob of an object's region, or ``None`` unless it is seen whole."""
        number = self._vision.number(source.channel, source.instance)
        if number is None:
            return None
        key = source.camera, source.channel, number
        region = self._vision.region(*key)
        if region is None or region.clipped:
            return None
        if source.part == "velocity":
            motion = self._motions.get(key)
            current = motion is not None and motion.image == self._vision.images
            return self._reading(motion.rate if motion is not None and current else None)
        blob = blob_of(self._robot.cameras[source.camera], region)
        if source.part == "extent":
            return self._reading(blob.extent)
        return self._reading(None if blob.orientation is None else np.array([blob.orientation]))

    def constellation(self, source: ConstellationSignal) -> Reading | None:
        """Return the constellation of two channels' blobs, or ``None`` unless both are whole."""
        blobs = []
        for channel in (source.channel, source.other):
            region = self._vision.region(source.camera, channel)
            if region is None or region.clipped:
                return None
            blobs.append(blob_of(self._robot.cameras[source.camera], region))
        return self._reading(constellation_of(*blobs).value)

    def offset(self, source: StereoOffset) -> Reading | None:
        """Return the displacement of a silhouette's centre from another object, m, world axes.

        The other object's remembered position is used, because the first one may occlude it partly.
        """
        first, second = self._vision.meeting(source.channel), self._placed(source.other)
        return None if first is None or second is None else self._reading(first - second)

    def _placed(self, channel: str) -> Floats | None:
        """Return the remembered, otherwise the seen position of a channel's object, m."""
        memory = self._vision.memory(channel)
        remembered = None if memory is None else memory.position
        return self._vision.meeting(channel) if remembered is None else remembered

    def feature(self, source: StereoSignal) -> Reading | None:
        """Return an object's velocity, m/s, or its volume, m^3, from stereo vision.

        A held object moves with the hand. The volume is that of a ball of the same apparent size.
        """
        number = self._vision.number(source.channel, source.instance)
        memory = None if number is None else self._vision.memory(source.channel, number)
        if memory is None:
            return None
        if source.part == "velocity":
            held = self._sight.motion(memory)
            return self._reading(
                memory.velocity if held is None else held.dot(self._joint_velocities)
            )
        if memory.position is None:
            return None
        return self._reading(np.array([4 / 3 * math.pi * memory.radius**3]))

    def count(self, source: InstanceCount) -> Reading | None:
        """Return the number of remembered objects of a channel, ``None`` before any image."""
        if not self._vision.images:
            return None
        known = self._vision.instances[source.channel].known
        return self._reading(np.array([float(len(known))]))

    def _follow(self, thing: tuple[str, str, int], time: float) -> None:
        seen, image = self._vision.heading(*thing), self._vision.images
        if seen is None or seen.stamp != image:
            return
        before, rate = self._motions.get(thing), None
        if before is not None and before.image == image - 1:
            rate = (seen.angles - before.angles) / (time - before.time)
        self._motions[thing] = _Motion(image, time, seen.angles, rate)

    def _reading(self, value: Floats | None) -> Reading | None:
        return None if value is None else Reading(value, None, self._vision.images)
