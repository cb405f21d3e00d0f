"""The robot's cameras, if they were ideal: regions of colour instead of images."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.ideal_cameras.links import Links
from cbdsl.backends.ideal_cameras.paint import Palette
from cbdsl.backends.ideal_cameras.silhouettes import WHOLE, silhouettes
from cbdsl.backends.ideal_cameras.solids import POSITION, WIDTH, placed
from cbdsl.backends.ideal_cameras.tree import Tree
from cbdsl.backends.kinematic.thing import Thing
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.shape import Shape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance, Spot
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.channels import Region
from cbdsl.sensing.kinematics import Kinematics

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
        channels: in which its colour is, of those that are looked for.
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

    Args:
        world: that it is in.
        palette: knows in which channels colours are.
        channels: that are looked for.
        cameras: how many there are.

    Attributes:
        solids: the world's, which has new ones when something comes or goes.
        sights: of all things and spots that it can see.
        targets: their solids and samples, as ``silhouettes`` has them, shape (sights, 2).
        patches: the parts of their surfaces, as ``silhouettes`` has them, shape (sights, 4).
        shapes: what the cameras see of them, shape (cameras, sights, 4).
    """

    def __init__(
        self, world: World, palette: Palette, channels: Collection[str], cameras: int
    ) -> None:
        self.solids = world.solids
        self._before = self.solids[:, POSITION].copy()
        self._shifts = np.zeros(len(self.solids))
        sees_motion = "motion" in channels
        # What is no fixture, where the robot looks for motion.
        things = enumerate(world.things.values())
        self._movable = [(row, thing) for row, thing in things if thing.mass and sees_motion]
        # What has none of the colours that are looked for is seen only by its motion.
        self.sights = [
            sight
            for sight in _sights(world, palette, channels)
            if sight.channels or (sight.target, sight.thing) in self._movable
        ]
        count = len(self.sights)
        targets = [(sight.target, sight.samples) for sight in self.sights]
        self.targets = np.array(targets, np.intp).reshape(count, 2)
        self.patches = np.array([sight.patch for sight in self.sights]).reshape(count, 4)
        self.shapes = np.zeros((cameras, count, 4))

    def moved(self) -> set[str]:
        """What has moved since this was asked before, where the robot looks for motion."""
        if not self._movable or not _have_moved(self.solids, self._before, self._shifts):
            return set()
        shifts = self._shifts.tolist()
        return {thing.name for row, thing in self._movable if shifts[row] > _LEAST_MOTION}


class Limbs:
    """The parts of arms that get in the way of the cameras: wrists and what they carry.

    Attributes:
        parts: solids in the frames of their links, shape (parts, 16).
        carriers: rows of these links in the tree, shape (parts,).
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, tree: Tree, links: Links
    ) -> None:
        arms = [effector for effector in robot.effectors.values() if effector.tip is not None]
        parts = [
            (tree.rows[link], solid)
            for arm in arms
            for link, solids in links.solids.items()
            for solid in solids
            if kinematics.moving(link).issuperset(arm.joints[: 1 - _WRIST])
        ]
        self.carriers = np.array([row for row, _ in parts], np.intp)
        self.parts = np.array([placed(solid.shape, solid.pose) for _, solid in parts])
        self.parts = self.parts.reshape(len(parts), WIDTH)


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
        channels: whose regions are looked for.
        disturbance: the sizes of the cameras' errors.
        rng: draws the errors.
    """

    def __init__(
        self,
        robot: RobotDocument,
        tree: Tree,
        limbs: Limbs,
        palette: Palette,
        channels: Collection[str],
        disturbance: Disturbance,
        rng: np.random.Generator,
    ) -> None:
        self._links = {name: camera.link for name, camera in robot.cameras.items()}
        self._rows = np.array([tree.rows[link] for link in self._links.values()], np.intp)
        self._lenses = np.array(
            [
                (camera.focal_length, float(camera.width), float(camera.height))
                for camera in robot.cameras.values()
            ]
        ).reshape(len(self._rows), 3)
        self._palette = palette
        self._channels = channels
        self._tree = tree
        self._limbs = limbs
        disturbed = disturbance.camera_position or disturbance.camera_rotation
        self._errors = {name: _error(disturbance, rng) for name in robot.cameras if disturbed}
        self._nothing: Mapping[str, Mapping[str, Region]] = {name: {} for name in robot.cameras}
        self._scene: _Scene | None = None

    def look(self, world: World) -> Mapping[str, Mapping[str, Region]]:
        """The largest region of each channel that is looked for, by camera and channel."""
        scene = self._scene
        if scene is None or scene.solids is not world.solids:
            scene = _Scene(world, self._palette, self._channels, len(self._rows))
            self._scene = scene
        seen = silhouettes(
            scene.solids,
            self._limbs.parts,
            self._limbs.carriers,
            self._tree.placements,
            scene.targets,
            scene.patches,
            self._placements(),
            self._rows,
            self._lenses,
            scene.shapes,
        )
        moved = scene.moved()
        if not seen:
            return self._nothing
        return {
            name: self._regions(scene.sights, shapes, moved)
            for name, shapes in zip(self._links, scene.shapes.tolist(), strict=True)
        }

    def _placements(self) -> Floats:
        """Where the cameras really are, in the rows of their links, as ``Tree`` has it."""
        if not self._errors:
            return self._tree.placements
        placements = self._tree.placements.copy()
        for row, (name, link) in zip(self._rows, self._links.items(), strict=True):
            pose = self._tree.pose(link) @ self._errors[name]
            placements[row, :9], placements[row, 9:] = pose.rotation.ravel(), pose.position
        return placements

    def _regions(
        self, sights: Sequence[_Sight], shapes: Sequence[Sequence[float]], moved: set[str]
    ) -> Mapping[str, Region]:
        found: dict[str, Region] = {}
        for sight, (area, column, row, clipped) in zip(sights, shapes, strict=True):
            whole = round(area)
            if whole == 0:
                continue
            region = Region(whole, column, row, bool(clipped))
            motion = ("motion",) if sight.thing.name in moved else ()
            for channel in sight.channels + motion:
                largest = found.get(channel)
                if largest is None or largest.area < whole:
                    found[channel] = region
        return found


@compiled_once
def _have_moved(solids: Floats, before: Floats, shifts: Floats) -> bool:
    """Whether any solid has moved far enough to be seen to move.

    Args:
        solids: as ``solids`` has them, shape (k, 16).
        before: where they were, m; becomes where they are, shape (k, 3).
        shifts: becomes how far each has moved, m, shape (k,).
    """
    have_moved = False
    for index in range(len(solids)):
        square = 0.0
        for part in range(3):
            now = solids[index, POSITION.start + part]
            square += (now - before[index, part]) ** 2
            before[index, part] = now
        shifts[index] = math.sqrt(square)
        have_moved |= shifts[index] > _LEAST_MOTION
    return have_moved


def _sights(world: World, palette: Palette, channels: Collection[str]) -> list[_Sight]:
    """All things, then the spots on them, whose area counts as their thing's, too."""

    def wanted(color: Sequence[float]) -> tuple[str, ...]:
        return tuple([name for name in palette.channels(color) if name in channels])

    wholes, spots = [], []
    for index, thing in enumerate(world.things.values()):
        spot = thing.shape.spot
        wholes.append(_Sight(thing, index, WHOLE, wanted(thing.surface.color)))
        if spot is not None:
            patch = _patch(thing.shape, spot)
            spots.append(_Sight(thing, index, patch, wanted(spot.color)))
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
