"""The robot's cameras, if they were ideal: regions of colour instead of images."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.bullet.pose import Pose
from cbdsl.backends.kinematic.links import Links
from cbdsl.backends.kinematic.paint import Palette
from cbdsl.backends.kinematic.shape import Shape
from cbdsl.backends.kinematic.solids import HALVES, POSITION, WIDTH, silhouettes
from cbdsl.backends.kinematic.thing import Thing
from cbdsl.backends.kinematic.world import World
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance
from cbdsl.robot.channels import Region
from cbdsl.robot.kinematics import Kinematics
from cbdsl.robot.urdf import UrdfModel

Floats = NDArray[np.float64]

# Lines of sight each way across a thing: its area is then right within half a percent.
_SAMPLES = 32
# Joints at the end of an arm whose links are wide, and often before the cameras.
_WRIST = 3
# Apparent motion that a camera notices, px.
_LEAST_MOTION = 1.0


class Limb:
    """The part of an arm that gets in the way of the cameras: its wrist and what it carries.

    Attributes:
        centre: link at its middle.
        radius: no part of it is further from the middle, m.
    """

    def __init__(
        self, kinematics: Kinematics, links: Links, centre: str, beyond: Sequence[str]
    ) -> None:
        self._kinematics = kinematics
        self.centre = centre
        self._parts = [
            (link, solid.pose, solid.shape)
            for link, solids in links.solids.items()
            for solid in solids
            if kinematics.moving(link).issuperset(beyond)
        ]
        self.radius = max((self._far(*part) for part in self._parts), default=0.0)

    def _far(self, link: str, pose: Pose, shape: Shape) -> float:
        frame, centre = self._kinematics.frame(link), self._kinematics.frame(self.centre)
        middle = frame.position + frame.rotation @ pose.position
        return float(np.linalg.norm(middle - centre.position)) + math.hypot(*shape.halves)

    def solids(self) -> Floats:
        """Its links where they are now, shape (links, 16)."""
        rows = np.empty((len(self._parts), WIDTH))
        for row, (link, pose, shape) in zip(rows, self._parts, strict=True):
            frame = self._kinematics.frame(link)
            row[0], row[HALVES] = shape.kind, shape.halves
            row[POSITION] = frame.position + frame.rotation.dot(pose.position)
            row[7:] = frame.rotation.dot(pose.rotation).ravel()
        return rows


class Cameras:
    """The cameras in one episode.

    Each is where the robot's model has it but for an error, drawn once: a distance in a random
    direction and an angle about a random axis. There is no noise of pixels, no shading, and
    nothing printed on boxes.

    Args:
        robot: names the cameras and their links.
        kinematics: where the links are.
        limbs: what may hide things.
        disturbance: the sizes of the cameras' errors.
        rng: draws the errors.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        limbs: Sequence[Limb],
        disturbance: Disturbance,
        rng: np.random.Generator,
    ) -> None:
        self._cameras = robot.cameras
        self._sees_motion = robot.vision.channels.motion
        self._palette = Palette(robot.vision.channels)
        self._kinematics = kinematics
        self._limbs = limbs
        self._errors = {name: _error(disturbance, rng) for name in robot.cameras}
        self._colors: dict[str, tuple[str, ...]] = {}
        self._before: dict[str, Floats] = {}

    def look(self, world: World) -> Mapping[str, Mapping[str, Region]]:
        """The largest region of each channel, by camera and channel."""
        solids, count = self._solids(world), len(world.things)
        seen = {}
        for name, camera in self._cameras.items():
            frame = self._kinematics.frame(camera.link)
            pose = Pose(frame.position, frame.rotation) @ self._errors[name]
            lens = camera.focal_length, float(camera.width), float(camera.height)
            shapes = silhouettes(solids, count, pose.position, pose.rotation, lens, _SAMPLES)
            moved = self._motion(world, pose.position, camera.focal_length)
            seen[name] = self._regions(world, shapes, moved)
        self._before = {name: thing.position.copy() for name, thing in world.things.items()}
        return seen

    def _solids(self, world: World) -> Floats:
        """Things first, then the parts of the robot that may be before them."""
        hiding = [limb.solids() for limb in self._limbs if self._in_the_way(limb, world)]
        return np.concatenate([world.solids, *hiding])

    def _in_the_way(self, limb: Limb, world: World) -> bool:
        """Whether a limb is near a line of sight to a thing that can be moved."""
        middle = self._kinematics.frame(limb.centre).position
        for camera in self._cameras.values():
            eye = self._kinematics.frame(camera.link).position
            for thing in world.things.values():
                if thing.mass and _near(eye, thing, middle, limb.radius):
                    return True
        return False

    def _motion(self, world: World, eye: Floats, focal_length: float) -> set[str]:
        """What moves noticeably across the image."""
        if not self._sees_motion:
            return set()
        return {
            name
            for name, thing in world.things.items()
            if thing.mass
            and name in self._before
            and focal_length * float(np.linalg.norm(thing.position - self._before[name]))
            > _LEAST_MOTION * float(np.linalg.norm(thing.position - eye))
        }

    def _regions(self, world: World, shapes: Floats, moved: set[str]) -> Mapping[str, Region]:
        found: dict[str, Region] = {}
        for thing, (area, column, row, clipped) in zip(
            world.things.values(), shapes.tolist(), strict=True
        ):
            if round(area) == 0:
                continue
            region = Region(round(area), column, row, bool(clipped))
            motion = ("motion",) if thing.name in moved else ()
            for channel in self._channels(thing) + motion:
                if channel not in found or found[channel].area < region.area:
                    found[channel] = region
        return found

    def _channels(self, thing: Thing) -> tuple[str, ...]:
        if thing.name not in self._colors:
            self._colors[thing.name] = self._palette.channels(thing.surface.color)
        return self._colors[thing.name]


def limbs(
    robot: RobotDocument, kinematics: Kinematics, model: UrdfModel, links: Links
) -> list[Limb]:
    """What of each arm may hide things."""
    return [
        Limb(kinematics, links, effector.tip.link, effector.joints[: 1 - _WRIST])
        for effector in robot.effectors.values()
        if effector.tip is not None
    ]


def _near(eye: Floats, thing: Thing, middle: Floats, radius: float) -> bool:
    """Whether a ball comes near the cone in which an eye sees something."""
    way = thing.position - eye
    distance = float(np.linalg.norm(way))
    offset = middle - eye
    along = float(offset @ way) / distance
    across = math.sqrt(max(float(offset @ offset) - along * along, 0.0))
    wide = math.hypot(*thing.shape.halves)
    return -radius < along < distance + radius + wide and across < radius + wide


def _error(disturbance: Disturbance, rng: np.random.Generator) -> Pose:
    turned = Pose.turned(_direction(rng), disturbance.camera_rotation)
    return Pose(disturbance.camera_position * _direction(rng), turned.rotation)


def _direction(rng: np.random.Generator) -> Floats:
    """A unit vector, shape (3,), drawn evenly from all directions."""
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)
