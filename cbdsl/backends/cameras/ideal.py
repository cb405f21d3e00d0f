"""Ideal cameras: regions of colour instead of images."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial, reduce
from itertools import chain, groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.cameras.camera_system import CameraSystem, Chance, Exposure
from cbdsl.backends.cameras.extents import box_extent
from cbdsl.backends.cameras.limbs import Limbs
from cbdsl.backends.cameras.silhouettes import SHAPE, WHOLE, silhouettes, unhidden
from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.backends.staging.solids import POSITION, Walls
from cbdsl.documents.form import Spot
from cbdsl.documents.robot import Channels, RobotDocument
from cbdsl.documents.stage import Disturbance
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats, Rows
from cbdsl.numeric.compiled import compiled_once
from cbdsl.robot.channel_names import channel_names, named_colors
from cbdsl.robot.channel_spans import channels_of_color
from cbdsl.robot.urdf import UrdfModel
from cbdsl.sensing.channels import FILLING, MOST_REGIONS, Extent, Moments, Region, Regions

# Lines of sight in each direction across an object: its area is then accurate within a percent.
_SAMPLES = 20
# Lines of sight across a fixture, whose area matters less.
_COARSE = 8
# Lines of sight across an object with a spot, which is small.
_FINE = 60
# Displacements below this from one image to the next do not count as motion, m.
_LEAST_MOTION = 2e-3
_ROUNDING = 1e-9
# Standard deviation of a region's area, px, per square root of its border's length, px, and per
# deviation of a pixel's value of 255. The noise of the sensor, of 2,
# decides whether a pixel that is half within the region counts.
_UNSURE = 0.15
# Number of regions for which errors are drawn at a time.
_AHEAD = 256


class VisibleSurface(NamedTuple):
    """Surface of one colour: a whole object, or a spot on it.

    Attributes:
        item: Object that the surface belongs to.
        owner: Index of the object among the engine's objects.
        target: Index of the solid with the surface among all solids that objects consist of.
        patch: Part of the solid's surface, as in ``silhouettes``.
        channels: Channels that are looked for and contain its colour.
    """

    item: SceneObject
    owner: int
    target: int
    patch: Sequence[float]
    channels: tuple[str, ...]

    @property
    def samples(self) -> int:
        """Lines of sight in each direction across the object."""
        if self.patch is not WHOLE:
            return _FINE
        return _SAMPLES if self.item.mass else _COARSE


class _Scene:
    """Surfaces that may be visible until an object is added or removed.

    Args:
        engine: Engine with the objects.
        division: Division of the images into channels.
        channels: Channels that are looked for.
        cameras: Number of cameras.

    Attributes:
        solids: The engine's solids; another array after an object is added or removed.
        surfaces: All surfaces that may be visible.
        targets: Solids and samples of the surfaces, as in ``silhouettes``, shape (surfaces, 2).
        patches: Patches, as in ``silhouettes``, shape (surfaces, 4).
        shapes: Silhouettes of the surfaces, shape (cameras, surfaces, SHAPE).
    """

    def __init__(
        self, engine: Engine, division: Channels, channels: Collection[str], cameras: int
    ) -> None:
        self.solids = engine.solids
        self._walls = Walls([item.shape for item in engine.objects.values()])
        self._before = self.solids[:, POSITION].copy()
        self._shifts = np.zeros(len(self.solids))
        sees_motion = "motion" in channels
        # Objects that are not fixtures, if the robot looks for motion.
        items = enumerate(engine.objects.values())
        self._movable = {row: item.name for row, item in items if item.mass and sees_motion}
        # A surface without a colour that is looked for is visible by its motion only.
        self.surfaces = [
            surface
            for surface in _surfaces(engine, self._walls.owners, division, channels)
            if surface.channels or surface.owner in self._movable
        ]
        count = len(self.surfaces)
        targets = [(surface.target, surface.samples) for surface in self.surfaces]
        self.targets = np.array(targets, np.intp).reshape(count, 2)
        self.patches = np.array([surface.patch for surface in self.surfaces]).reshape(count, 4)
        self.shapes = np.zeros((cameras, count, SHAPE))

    def all_solids(self) -> Floats:
        """Return all solids that objects consist of at their current poses, shape (m, 16)."""
        return self._walls.at(self.solids)

    def whole(
        self, shapes: Sequence[Sequence[float]]
    ) -> Iterable[tuple[VisibleSurface, Sequence[float]]]:
        """Return all surfaces with their shapes in an image; a hollow object has one per colour."""
        pairs = zip(self.surfaces, shapes, strict=True)
        return _joined(pairs) if len(self._walls.owners) > len(self.solids) else pairs

    def moved(self) -> set[str]:
        """Return the objects that moved since the last call, if the robot looks for motion."""
        if not self._movable or not _have_moved(self.solids, self._before, self._shifts):
            return set()
        shifts = self._shifts.tolist()
        return {name for row, name in self._movable.items() if shifts[row] > _LEAST_MOTION}


class IdealCameras(CameraSystem):
    """Cameras without pixels and shading; see ``CameraSystem``.

    Regions have errors as if they had been counted pixel by pixel. Of prints on boxes, only spots
    are visible.

    Args:
        robot: Robot document, which names the cameras and their links.
        model: URDF model of the robot.
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
        self._filled = (FILLING * self._lenses[:, 1] * self._lenses[:, 2]).tolist()
        self._limbs = Limbs(robot, model)
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
        deviation = math.hypot(self._robot.vision.noise, disturbance.image_noise)
        self._region_errors = RegionErrors(deviation, chance.noise.spawn(1)[0])
        self.look_for(channels)
        self._rows = np.array([engine.rows[link] for link in self._links.values()], np.intp)
        self._carriers = np.array([engine.rows[link] for link in self._limbs.links], np.intp)

    def look_for(self, channels: Collection[str] | None) -> None:
        """Look for regions of other channels from now on."""
        every = tuple(channel_names(self._robot.vision.channels))
        self._channels = every if channels is None else channels
        self._scene: _Scene | None = None

    def take_in_the_dark(self) -> Exposure:
        """Return no regions."""
        return self._nothing

    def colors(self) -> tuple[str, ...]:
        """Return the named colours of all visible surfaces."""
        vision = self._robot.vision
        names = tuple(named_colors(vision.channels))
        scene = _Scene(self._engine, vision.channels, names, len(self._rows))
        self._project(scene, scene.all_solids(), self._misplaced(self._engine.placements))
        seen = {
            channel
            for shapes in scene.shapes.tolist()
            for surface, shape in scene.whole(shapes)
            if shape[0] >= vision.regions.least_area
            for channel in surface.channels
        }
        return tuple(name for name in names if name in seen)

    def _project(self, scene: _Scene, placed: Floats, cameras: Floats) -> bool:
        """Write the silhouettes of a scene's surfaces; return whether there is any."""
        return bool(
            silhouettes(
                placed, self._limbs.parts, self._carriers, self._engine.placements, scene.targets,
                scene.patches, cameras, self._rows, self._lenses, scene.shapes,
            )
        )  # fmt: skip

    def take(self) -> Exposure:
        """Return the regions of each channel that is looked for, by camera and channel."""
        engine, scene = self._engine, self._scene
        solids, placements = engine.solids, engine.placements
        # An engine allocates another array whenever an object is added or removed, so identity
        # suffices.
        if scene is None or scene.solids is not solids:
            scene = self._scene = _Scene(
                engine, self._robot.vision.channels, self._channels, len(self._rows)
            )
        placed, cameras = scene.all_solids(), self._misplaced(placements)
        seen = self._project(scene, placed, cameras)
        # The call also stores the positions for the next image. So it precedes the return without
        # regions.
        moved = scene.moved()
        if not seen:
            return self._nothing
        regions = {
            name: _regions(
                scene.whole(shapes),
                moved,
                filled,
                self._region_errors,
                partial(self._extent, placed, lens, cameras[row]),
            )
            for name, shapes, lens, filled, row in zip(
                self._links,
                scene.shapes.tolist(),
                self._lenses,
                self._filled,
                self._rows,
                strict=True,
            )
        }
        return Exposure(regions=regions)

    def _extent(
        self, solids: Floats, lens: Floats, place: Floats, surface: VisibleSurface
    ) -> Extent | None:
        """Return the visible part of a box from a camera's placement; ``None`` for other shapes."""
        if surface.patch is not WHOLE or surface.item.shape.kind != "box":
            return None

        def seen_at(pixels: Floats) -> NDArray[np.bool_]:
            slopes, seen = (lens[1:] / 2 - pixels) / lens[0], np.empty(len(pixels), dtype=np.bool_)
            unhidden(
                solids, self._limbs.parts, self._carriers, self._engine.placements,
                surface.target, place, slopes, seen,
            )  # fmt: skip
            return seen

        return box_extent(solids[surface.target], place, lens, seen_at)

    def _misplaced(self, placements: Floats) -> Floats:
        """Return the placements of the links, with those of the cameras in their links' rows."""
        if not self._errors:
            return placements
        placements = placements.copy()
        for row, name in zip(self._rows, self._links, strict=True):
            own = placements[row]
            pose = Pose(own[9:], own[:9].reshape(3, 3)) @ self._errors[name]
            own[:9], own[9:] = pose.rotation.ravel(), pose.position
        return placements


def _regions(
    surfaces: Iterable[tuple[VisibleSurface, Sequence[float]]],
    moved: set[str],
    filled: float,
    errors: RegionErrors,
    extent: Callable[[VisibleSurface], Extent | None],
) -> Mapping[str, Regions]:
    """Return regions of each channel, the largest first, from all surfaces' shapes in an image.

    Clipped regions larger than ``filled``, px, have an extent.
    """
    by_channel: dict[str, dict[int, Region]] = {}
    for surface, (area, column, row, clipped, columns, mixed, rows) in surfaces:
        # A silhouette of less than half a pixel counts as no pixel.
        if round(area) == 0:
            continue
        channels = surface.channels
        area, column, row = errors.added(area, column, row)
        whole = round(area)
        fills = clipped and channels and area >= filled
        moments, visible = Moments(columns, mixed, rows), extent(surface) if fills else None
        region = Region(whole, column, row, clipped != 0.0, moments, visible)
        if surface.item.name in moved:
            channels = (*channels, "motion")
        for channel in channels:
            # A spot comes after its object, whose area includes that of the spot.
            by_channel.setdefault(channel, {}).setdefault(surface.owner, region)
    return {channel: _connected([*of.values()]) for channel, of in by_channel.items()}


def _connected(regions: list[Region]) -> Regions:
    """Merge regions that overlap in an image; return them with the largest first."""
    if len(regions) == 1:
        return (regions[0],)
    # In an image, touching silhouettes of one colour are one connected region. Silhouettes are
    # compared one by one: the ellipse of a union also covers places where nothing is, so that the
    # result would depend on the order.
    parts: list[list[Region]] = []
    for region in regions:
        joined = [part for part in parts if any(_overlap(each, region) for each in part)]
        parts = [part for part in parts if not any(part is each for each in joined)]
        parts.append([*chain(*joined), region])
    merged = (reduce(lambda union, each: _union(each, union), part) for part in parts)
    return tuple(sorted(merged, key=lambda each: -each.area)[:MOST_REGIONS])


def _overlap(one: Region, other: Region) -> bool:
    """Return whether the moments' ellipses of two regions touch along the line between them."""
    # A uniform ellipse has the variance a^2 / 4 along a half axis a. So its half width in a
    # direction is twice the standard deviation there. The comparison of half widths is exact for
    # discs. Two oblique ellipses that pass each other closely may count as one.
    across, down = other.column - one.column, other.row - one.row
    distance = math.hypot(across, down)
    if distance == 0.0:
        return True
    reach = 0.0
    for columns, mixed, rows in (one.moments, other.moments):
        square = columns * across**2 + 2 * mixed * across * down + rows * down**2
        reach += 2 * math.sqrt(square) / distance
    return distance <= reach


def _union(one: Region, other: Region) -> Region:
    """Return two regions as one."""
    area = one.area + other.area
    share, rest = one.area / area, other.area / area
    across, down = other.column - one.column, other.row - one.row
    spread = share * rest
    # The variance of a union is the mean of the variances plus the variance of the centroids.
    moments = Moments(
        share * one.moments.columns + rest * other.moments.columns + spread * across**2,
        share * one.moments.mixed + rest * other.moments.mixed + spread * across * down,
        share * one.moments.rows + rest * other.moments.rows + spread * down**2,
    )
    column, row = one.column + rest * across, one.row + rest * down
    extent = max(one, other, key=lambda each: each.area).extent
    return Region(area, column, row, one.clipped or other.clipped, moments, extent)


def _joined(
    pairs: Iterable[tuple[VisibleSurface, Sequence[float]]],
) -> Iterator[tuple[VisibleSurface, Sequence[float]]]:
    """Yield surfaces with their shapes, with all walls of a hollow object as one."""
    for _, group in groupby(pairs, lambda pair: (pair[0].owner, pair[0].patch is WHOLE)):
        parts = list(group)
        surface = parts[0][0]
        yield surface, parts[0][1] if len(parts) == 1 else _sum([shape for _, shape in parts])


def _sum(shapes: Sequence[Sequence[float]]) -> Sequence[float]:
    """Return the combined shape of disjoint visible parts, as in ``silhouettes``."""
    each = np.array(shapes)
    area = float(each[:, 0].sum())
    if area == 0.0:
        return shapes[0]
    shares = each[:, 0] / area
    column, row = (shares @ each[:, 1:3]).tolist()
    columns, rows = each[:, 1] - column, each[:, 2] - row
    # As in ``_union``: the spread of the parts' centroids adds to the moments of the whole.
    spread = np.stack((columns * columns, columns * rows, rows * rows), axis=1)
    moments = shares @ (each[:, 4:] + spread)
    return [area, column, row, float(each[:, 3].max()), *moments.tolist()]


@compiled_once
def _have_moved(solids: Floats, before: Floats, shifts: Floats) -> bool:
    """Return whether any solid has moved far enough to count as motion.

    Args:
        solids: Rows of the solids, as in ``solids``, shape (k, 16).
        before: Positions at the last call, m, shape (k, 3); overwritten by the current ones.
        shifts: Output: distance that each solid has moved, m, shape (k,).
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


def _surfaces(
    engine: Engine, owners: Rows, division: Channels, channels: Collection[str]
) -> list[VisibleSurface]:
    """Return all solids, then their spots, whose area also counts as their object's."""

    @cache
    def wanted(color: Sequence[float]) -> tuple[str, ...]:
        return tuple(each for each in channels_of_color(color, division) if each in channels)

    wholes, spots = [], []
    items = list(engine.objects.values())
    for target, owner in enumerate(owners.tolist()):
        item = items[owner]
        wholes.append(VisibleSurface(item, owner, target, WHOLE, wanted(tuple(item.surface.color))))
        for spot in item.shape.spots:
            patch = _patch(item.shape, spot)
            spots.append(VisibleSurface(item, owner, target, patch, wanted(tuple(spot.color))))
    return wholes + spots


def _patch(shape: SolidShape, spot: Spot) -> tuple[float, float, float, float]:
    """Return a spot as a patch, as in ``silhouettes``."""
    side = -1.0 if spot.face.startswith("-") else 1.0
    # A ray meets a plane only within rounding errors.
    height = shape.spot_height(spot) - _ROUNDING
    return float("xy".index(spot.face[1])), side, height, spot.radius


# Model: the sensor's noise decides for each pixel of a region's border whether it counts. Let the
# border have n = 2 pi r pixels with independent errors of standard deviation s, where r is the
# radius of a disc with the region's area A. Then
#     deviation of the area       s sqrt(n)
#     deviation of the centroid   s sqrt(n / 2) r / A, in each direction
# since the error of a border pixel at the angle phi shifts the centroid by r cos(phi) / A, and the
# mean of cos(phi)^2 is 1/2. Assumptions: the region is nearly round, and s is proportional to the
# noise of a pixel. A long, thin region has a longer border than its disc, and larger errors.
class RegionErrors:
    """Errors of regions whose border pixels may count or not.

    Args:
        deviation: Standard deviation of a pixel's value, of 255.
        rng: Generator of the errors.
    """

    def __init__(self, deviation: float, rng: np.random.Generator) -> None:
        self._unsure, self._rng = _UNSURE * deviation, rng
        self._drawn: list[list[float]] = []

    def added(self, area: float, column: float, row: float) -> tuple[float, float, float]:
        """Return area and centroid, px, with errors; a region keeps at least one pixel."""
        if not self._drawn:
            self._drawn = self._rng.standard_normal((_AHEAD, 3)).tolist()
        larger, aside, below = self._drawn.pop()
        radius = math.sqrt(area / math.pi)
        off = self._unsure * math.sqrt(2 * math.pi * radius)
        # Pixels of the border are a radius away from the centroid, on either side.
        shift = off * radius / area / math.sqrt(2)
        return max(area + off * larger, 1.0), column + shift * aside, row + shift * below
