"""The robot's cameras, if they were ideal: regions of colour instead of images."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.links import Links
from cbdsl.backends.kinematic.paint import Palette
from cbdsl.backends.kinematic.solids import WIDTH, attached, placed, silhouettes
from cbdsl.backends.kinematic.tree import Tree
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.pose import Pose
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance
from cbdsl.robot.channels import Region
from cbdsl.robot.kinematics import Kinematics

Floats = NDArray[np.float64]

# Lines of sight each way across a thing: its area is then right within a percent.
_SAMPLES = 20
# And across a fixture, whose area matters less.
_COARSE = 8
# Joints at the end of an arm whose links are wide, and often before the cameras.
_WRIST = 3
# What has moved less from one image to the next does not count as motion, m.
_LEAST_MOTION = 2e-3


class Limb:
    """The part of an arm that gets in the way of the cameras: its wrist and what it carries."""

    def __init__(
        self, kinematics: Kinematics, tree: Tree, links: Links, beyond: Sequence[str]
    ) -> None:
        self._tree = tree
        parts = [
            (tree.rows[link], solid)
            for link, solids in links.solids.items()
            for solid in solids
            if kinematics.moving(link).issuperset(beyond)
        ]
        self._rows = np.array([row for row, _ in parts], dtype=np.intp)
        self._parts = np.array([placed(solid.shape, solid.pose) for _, solid in parts])
        self._parts = self._parts.reshape(len(parts), WIDTH)

    def solids(self) -> Floats:
        """Its links where they are now, shape (links, 16)."""
        return attached(self._parts, self._tree.placements, self._rows)


class Cameras:
    """The cameras in one episode.

    Each is where the robot's model has it but for an error, drawn once: a distance in a random
    direction and an angle about a random axis. There is no noise of pixels, no shading, and
    nothing printed on boxes.

    Args:
        robot: names the cameras and their links.
        tree: where the links are.
        limbs: what may hide things.
        palette: knows in which channels colours are.
        disturbance: the sizes of the cameras' errors.
        rng: draws the errors.
    """

    def __init__(
        self,
        robot: RobotDocument,
        tree: Tree,
        limbs: Sequence[Limb],
        palette: Palette,
        disturbance: Disturbance,
        rng: np.random.Generator,
    ) -> None:
        self._cameras = robot.cameras
        self._sees_motion = robot.vision.channels.motion
        self._palette = palette
        self._tree = tree
        self._limbs = limbs
        self._errors = {name: _error(disturbance, rng) for name in robot.cameras}
        self._disturbed = bool(disturbance.camera_position or disturbance.camera_rotation)
        self._before: dict[str, tuple[float, ...]] = {}

    def look(self, world: World) -> Mapping[str, Mapping[str, Region]]:
        """The largest region of each channel, by camera and channel."""
        # Things first, then the parts of the robot that may be before them.
        solids = np.concatenate([world.solids, *(limb.solids() for limb in self._limbs)])
        things = world.things.values()
        samples = np.array([_SAMPLES if thing.mass else _COARSE for thing in things], np.intp)
        moved = self._motion(world)
        seen = {}
        for name, camera in self._cameras.items():
            pose = self._pose(name)
            lens = camera.focal_length, float(camera.width), float(camera.height)
            found = silhouettes(solids, samples, pose.position, pose.rotation, lens)
            seen[name] = self._regions(world, found, moved)
        return seen

    def _pose(self, camera: str) -> Pose:
        """Where a camera really is."""
        pose = self._tree.pose(self._cameras[camera].link)
        return pose @ self._errors[camera] if self._disturbed else pose

    def _motion(self, world: World) -> set[str]:
        """What has moved since the last look."""
        if not self._sees_motion:
            return set()
        before, self._before = (
            self._before,
            {name: tuple(thing.position.tolist()) for name, thing in world.things.items()},
        )
        return {
            name
            for name, position in self._before.items()
            if math.dist(position, before.get(name, position)) > _LEAST_MOTION
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
            for channel in self._palette.channels(thing.surface.color) + motion:
                if channel not in found or found[channel].area < region.area:
                    found[channel] = region
        return found


def limbs(robot: RobotDocument, kinematics: Kinematics, tree: Tree, links: Links) -> list[Limb]:
    """What of each arm may hide things."""
    return [
        Limb(kinematics, tree, links, effector.joints[: 1 - _WRIST])
        for effector in robot.effectors.values()
        if effector.tip is not None
    ]


def _error(disturbance: Disturbance, rng: np.random.Generator) -> Pose:
    turned = Pose.turned(_direction(rng), disturbance.camera_rotation)
    return Pose(disturbance.camera_position * _direction(rng), turned.rotation)


def _direction(rng: np.random.Generator) -> Floats:
    """A unit vector, shape (3,), drawn evenly from all directions."""
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)
