"""The robot's cameras, if they were ideal: regions of colour instead of images."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.links import Links
from cbdsl.backends.kinematic.paint import Palette
from cbdsl.backends.kinematic.solids import WHOLE, WIDTH, attached, placed, silhouettes
from cbdsl.backends.kinematic.thing import Thing
from cbdsl.backends.kinematic.tree import Tree
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.pose import Pose
from cbdsl.backends.shape import Shape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance, Spot
from cbdsl.robot.channels import Region
from cbdsl.robot.kinematics import Kinematics

Floats = NDArray[np.float64]

# Lines of sight each way across a thing: its area is then right within a percent.
_SAMPLES = 20
# And across a fixture, whose area matters less.
_COARSE = 8
# And across a thing with a spot, which is small.
_FINE = 60
# Joints at the end of an arm whose links are wide, and often before the cameras.
_WRIST = 3
# What has moved less from one image to the next does not count as motion, m.
_LEAST_MOTION = 2e-3
_ROUNDING = 1e-9


class _Sight(NamedTuple):
    """Something of one colour that there is to see: a thing, or the spot on it.

    Attributes:
        thing: what it belongs to.
        target: its index among the world's things.
        patch: the part of its surface, as ``silhouettes`` has it.
        channels: in which its colour is.
    """

    thing: Thing
    target: int
    patch: Sequence[float]
    channels: tuple[str, ...]

    @property
    def samples(self) -> int:
        """Lines of sight each way across the thing."""
        if self.patch is not WHOLE:
            return _FINE
        return _SAMPLES if self.thing.mass else _COARSE


class _Scene:
    """What there is to see until something comes or goes.

    Attributes:
        solids: the world's, which has new ones when something comes or goes.
        sights: of all things and spots.
        wanted: targets, patches and samples, as ``silhouettes`` has them.
    """

    def __init__(self, world: World, palette: Palette) -> None:
        self.solids = world.solids
        self.sights = _sights(world, palette)
        self.wanted = (
            np.array([sight.target for sight in self.sights], np.intp),
            np.array([sight.patch for sight in self.sights]).reshape(len(self.sights), 4),
            np.array([sight.samples for sight in self.sights], np.intp),
        )


class Limbs:
    """The parts of arms that get in the way of the cameras: wrists and what they carry."""

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, tree: Tree, links: Links
    ) -> None:
        self._tree = tree
        arms = [effector for effector in robot.effectors.values() if effector.tip is not None]
        parts = [
            (tree.rows[link], solid)
            for arm in arms
            for link, solids in links.solids.items()
            for solid in solids
            if kinematics.moving(link).issuperset(arm.joints[: 1 - _WRIST])
        ]
        self._rows = np.array([row for row, _ in parts], dtype=np.intp)
        self._parts = np.array([placed(solid.shape, solid.pose) for _, solid in parts])
        self._parts = self._parts.reshape(len(parts), WIDTH)

    def solids(self) -> Floats:
        """Their links where they are now, shape (links, 16)."""
        return attached(self._parts, self._tree.placements, self._rows)


class Cameras:
    """The cameras in one episode.

    Each is where the robot's model has it but for an error, drawn once: a distance in a random
    direction and an angle about a random axis. There is no noise of pixels, no shading, and
    nothing printed on boxes but spots.

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
        limbs: Limbs,
        palette: Palette,
        disturbance: Disturbance,
        rng: np.random.Generator,
    ) -> None:
        self._cameras = robot.cameras
        self._lenses = {
            name: (camera.focal_length, float(camera.width), float(camera.height))
            for name, camera in robot.cameras.items()
        }
        self._sees_motion = robot.vision.channels.motion
        self._palette = palette
        self._tree = tree
        self._limbs = limbs
        self._errors = {name: _error(disturbance, rng) for name in robot.cameras}
        self._disturbed = bool(disturbance.camera_position or disturbance.camera_rotation)
        self._before: dict[str, list[float]] = {}
        self._scene = _Scene(World(), palette)

    def look(self, world: World) -> Mapping[str, Mapping[str, Region]]:
        """The largest region of each channel, by camera and channel."""
        # Things first, then the parts of the robot that may be before them.
        solids = np.concatenate((world.solids, self._limbs.solids()))
        if self._scene.solids is not world.solids:
            self._scene = _Scene(world, self._palette)
        sights, wanted = self._scene.sights, self._scene.wanted
        moved = self._motion(world)
        seen = {}
        for name, lens in self._lenses.items():
            pose = self._pose(name)
            found = silhouettes(solids, *wanted, pose.position, pose.rotation, lens)
            seen[name] = self._regions(sights, found, moved)
        return seen

    def _pose(self, camera: str) -> Pose:
        """Where a camera really is."""
        pose = self._tree.pose(self._cameras[camera].link)
        return pose @ self._errors[camera] if self._disturbed else pose

    def _motion(self, world: World) -> set[str]:
        """What has moved since the last look."""
        moved = set()
        for name, thing in world.things.items() if self._sees_motion else ():
            position = thing.position.tolist()
            if math.dist(position, self._before.get(name, position)) > _LEAST_MOTION:
                moved.add(name)
            self._before[name] = position
        return moved

    def _regions(
        self, sights: Sequence[_Sight], shapes: Floats, moved: set[str]
    ) -> Mapping[str, Region]:
        found: dict[str, Region] = {}
        for sight, (area, column, row, clipped) in zip(sights, shapes.tolist(), strict=True):
            if round(area) == 0:
                continue
            region = Region(round(area), column, row, bool(clipped))
            motion = ("motion",) if sight.thing.name in moved else ()
            for channel in sight.channels + motion:
                if channel not in found or found[channel].area < region.area:
                    found[channel] = region
        return found


def _sights(world: World, palette: Palette) -> list[_Sight]:
    """All things, then the spots on them, whose area counts as their thing's, too."""
    wholes, spots = [], []
    for index, thing in enumerate(world.things.values()):
        spot = thing.shape.spot
        wholes.append(_Sight(thing, index, WHOLE, palette.channels(thing.surface.color)))
        if spot is not None:
            patch = _patch(thing.shape, spot)
            spots.append(_Sight(thing, index, patch, palette.channels(spot.color)))
    return wholes + spots


def _patch(shape: Shape, spot: Spot) -> tuple[float, float, float, float]:
    """A spot as ``silhouettes`` has it."""
    side = -1.0 if spot.face.startswith("-") else 1.0
    # A ray meets a plane but for rounding.
    height = shape.spot_height() - _ROUNDING
    return float("xy".index(spot.face[1])), side, height, spot.radius


def _error(disturbance: Disturbance, rng: np.random.Generator) -> Pose:
    turned = Pose.turned(_direction(rng), disturbance.camera_rotation)
    return Pose(disturbance.camera_position * _direction(rng), turned.rotation)


def _direction(rng: np.random.Generator) -> Floats:
    """A unit vector, shape (3,), drawn evenly from all directions."""
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)
