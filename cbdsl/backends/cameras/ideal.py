"""Ideal cameras: regions of colour instead of images."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.cameras.camera_system import CameraSystem, Chance, Exposure
from cbdsl.backends.cameras.limbs import Limbs
from cbdsl.backends.cameras.palette import Palette
from cbdsl.backends.cameras.silhouettes import WHOLE, silhouettes
from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.backends.staging.solids import POSITION
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance, Spot
from cbdsl.numeric.compiled import compiled_once
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.urdf import UrdfModel
from cbdsl.sensing.channels import Region

Floats = NDArray[np.float64]

# Lines of sight each way across a thing: its area is then right within a percent.
_SAMPLES = 20
# And across a fixture, whose area matters less.
_COARSE = 8
# And across a thing with a spot, which is small.
_FINE = 60
# What has moved less from one image to the next does not count as motion, m.
_LEAST_MOTION = 2e-3
_ROUNDING = 1e-9


class VisibleSurface(NamedTuple):
    """A surface of one colour: a whole object, or the spot on it.

    Attributes:
        item: what it belongs to.
        target: its index among the engine's objects.
        patch: the part of the object's surface, as ``silhouettes`` has it.
        channels: in which its colour is, of those that are looked for.
    """

    item: SceneObject
    target: int
    patch: Sequence[float]
    channels: tuple[str, ...]

    @property
    def samples(self) -> int:
        """Lines of sight each way across the object."""
        if self.patch is not WHOLE:
            return _FINE
        return _SAMPLES if self.item.mass else _COARSE


class _Scene:
    """Surfaces to be seen until an object comes or goes.

    Args:
        engine: that it is in.
        palette: knows in which channels colours are.
        channels: that are looked for.
        cameras: how many there are.

    Attributes:
        solids: the engine's, which has new ones when something comes or goes.
        surfaces: all that can be seen.
        targets: their solids and samples, as ``silhouettes`` has them, shape (surfaces, 2).
        patches: as ``silhouettes`` has them, shape (surfaces, 4).
        shapes: what the cameras see of them, shape (cameras, surfaces, 4).
    """

    def __init__(
        self, engine: Engine, palette: Palette, channels: Collection[str], cameras: int
    ) -> None:
        self.solids = engine.solids
        self._before = self.solids[:, POSITION].copy()
        self._shifts = np.zeros(len(self.solids))
        sees_motion = "motion" in channels
        # What is no fixture, where the robot looks for motion.
        items = enumerate(engine.objects.values())
        self._movable = {row: item.name for row, item in items if item.mass and sees_motion}
        # What has none of the colours that are looked for is seen only by its motion.
        self.surfaces = [
            surface
            for surface in _surfaces(engine, palette, channels)
            if surface.channels or surface.target in self._movable
        ]
        count = len(self.surfaces)
        targets = [(surface.target, surface.samples) for surface in self.surfaces]
        self.targets = np.array(targets, np.intp).reshape(count, 2)
        self.patches = np.array([surface.patch for surface in self.surfaces]).reshape(count, 4)
        self.shapes = np.zeros((cameras, count, 4))

    def moved(self) -> set[str]:
        """Objects that moved since the call before, where the robot looks for motion."""
        if not self._movable or not _have_moved(self.solids, self._before, self._shifts):
            return set()
        shifts = self._shifts.tolist()
        return {name for row, name in self._movable.items() if shifts[row] > _LEAST_MOTION}


class IdealCameras(CameraSystem):
    """Cameras without noise of pixels and shading; see ``CameraSystem``.

    They see nothing that is printed on boxes but spots.

    Args:
        robot: names the cameras and their links.
        model: of the robot.
    """

    def __init__(self, robot: RobotDocument, model: UrdfModel) -> None:
        super().__init__(robot, "ideal cameras" if robot.cameras else "nothing")
        self._links = {name: camera.link for name, camera in robot.cameras.items()}
        self._lenses = np.array(
            [
                (camera.focal_length, float(camera.width), float(camera.height))
                for camera in robot.cameras.values()
            ]
        ).reshape(len(self._links), 3)
        self._limbs = Limbs(robot, model)
        self._palette = Palette(robot.vision.channels)
        self._nothing = Exposure(regions={name: {} for name in robot.cameras})

    def begin(
        self,
        engine: Engine,
        disturbance: Disturbance,
        channels: Collection[str] | None,
        chance: Chance,
    ) -> None:
        """Begin an episode."""
        super().begin(engine, disturbance, channels, chance)
        every = tuple(channel_names(self._robot.vision.channels))
        self._channels = every if channels is None else channels
        self._rows = np.array([engine.rows[link] for link in self._links.values()], np.intp)
        self._carriers = np.array([engine.rows[link] for link in self._limbs.links], np.intp)
        self._scene: _Scene | None = None

    def take(self) -> Exposure:
        """The largest region of each channel that is looked for, by camera and channel."""
        engine, scene = self._engine, self._scene
        solids, placements = engine.solids, engine.placements
        if scene is None or scene.solids is not solids:
            scene = self._scene = _Scene(engine, self._palette, self._channels, len(self._rows))
        seen = silhouettes(
            scene.solids,
            self._limbs.parts,
            self._carriers,
            placements,
            scene.targets,
            scene.patches,
            self._misplaced(placements),
            self._rows,
            self._lenses,
            scene.shapes,
        )
        moved = scene.moved()
        if not seen:
            return self._nothing
        regions = {
            name: _regions(scene.surfaces, shapes, moved)
            for name, shapes in zip(self._links, scene.shapes.tolist(), strict=True)
        }
        return Exposure(regions=regions)

    def _misplaced(self, placements: Floats) -> Floats:
        """Placements of the links, with those of the cameras in the rows of theirs."""
        if not self._errors:
            return placements
        placements = placements.copy()
        for row, name in zip(self._rows, self._links, strict=True):
            own = placements[row]
            pose = Pose(own[9:], own[:9].reshape(3, 3)) @ self._errors[name]
            own[:9], own[9:] = pose.rotation.ravel(), pose.position
        return placements


def _regions(
    surfaces: Sequence[VisibleSurface], shapes: Sequence[Sequence[float]], moved: set[str]
) -> Mapping[str, Region]:
    """The largest region of each channel, from the shapes of all surfaces in an image."""
    regions: dict[str, Region] = {}
    for surface, (area, column, row, clipped) in zip(surfaces, shapes, strict=True):
        whole = round(area)
        if whole == 0:
            continue
        region = Region(whole, column, row, bool(clipped))
        motion = ("motion",) if surface.item.name in moved else ()
        for channel in surface.channels + motion:
            largest = regions.get(channel)
            if largest is None or largest.area < whole:
                regions[channel] = region
    return regions


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


def _surfaces(engine: Engine, palette: Palette, channels: Collection[str]) -> list[VisibleSurface]:
    """All objects, then the spots on them, whose area counts as their object's, too."""

    def wanted(color: Sequence[float]) -> tuple[str, ...]:
        return tuple([name for name in palette.channels(color) if name in channels])

    wholes, spots = [], []
    for index, item in enumerate(engine.objects.values()):
        spot = item.shape.spot
        wholes.append(VisibleSurface(item, index, WHOLE, wanted(item.surface.color)))
        if spot is not None:
            patch = _patch(item.shape, spot)
            spots.append(VisibleSurface(item, index, patch, wanted(spot.color)))
    return wholes + spots


def _patch(shape: SolidShape, spot: Spot) -> tuple[float, float, float, float]:
    """A spot as ``silhouettes`` has it."""
    side = -1.0 if spot.face.startswith("-") else 1.0
    # A ray meets a plane but for rounding.
    height = shape.spot_height() - _ROUNDING
    return float("xy".index(spot.face[1])), side, height, spot.radius
