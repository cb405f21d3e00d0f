"""Shapes of definite size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from cbdsl.documents.form import (
    MOST_PIECES,
    BallForm,
    BoxForm,
    ComposedForm,
    CylinderForm,
    Form,
    MeshForm,
    OpenBoxForm,
    Pattern,
    Piece,
    Spot,
    TubeForm,
)
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.box_cover import cover
from cbdsl.numeric.convex import Convex
from cbdsl.robot.meshes.mesh_reader import Mesh
from cbdsl.robot.meshes.thing_mesh import changed, read_thing_mesh
from cbdsl.robot.urdf import UrdfOrigin

# Number of boxes that the wall of a tube consists of.
_SIDES = 12


def draw(span: tuple[float, float], rng: np.random.Generator) -> float:
    """Draw from the uniform distribution over a span."""
    return float(rng.uniform(*span))


class Wall(NamedTuple):
    """Solid that is a part of a hollow shape.

    Attributes:
        shape: Shape of the solid.
        origin: Origin in the frame of the hollow shape.
    """

    shape: SolidShape
    origin: UrdfOrigin


@dataclass(frozen=True)
class SolidShape:
    """Ball, box or cylinder, or a hollow shape that consists of them.

    Attributes:
        kind: Kind of the shape, or of its envelope if it is hollow; a cylinder stands along its z.
        halves: Half extents along its own axes, m.
        pattern: Print on a box.
        spots: Painted spots on the sides of a ball, a box or a cylinder.
        walls: Solids of a hollow shape; those of a hull fill it, for code that supports balls,
            boxes and cylinders only.
        mesh: Visible mesh, m, in its frame, if there is one.
        hull: Corners of the colliding convex hull, m, shape (k, 3), if there is one.
    """

    kind: Literal["ball", "box", "cylinder"]
    halves: tuple[float, float, float]
    pattern: Pattern | None = None
    spots: tuple[Spot, ...] = ()
    walls: tuple[Wall, ...] = ()
    mesh: Mesh | None = field(default=None, compare=False, repr=False)
    hull: Floats | None = field(default=None, compare=False, repr=False)

    @classmethod
    def ball(cls, radius: float, spots: tuple[Spot, ...] = ()) -> SolidShape:
        """Return a ball of a radius, m."""
        return cls("ball", (radius, radius, radius), spots=spots)

    @classmethod
    def cylinder(cls, radius: float, height: float, spots: tuple[Spot, ...] = ()) -> SolidShape:
        """Return a cylinder of a radius and a height, m."""
        return cls("cylinder", (radius, radius, height / 2), spots=spots)

    @classmethod
    def tube(cls, radius: float, height: float, wall: float) -> SolidShape:
        """Return a tube along its z, of an outer radius, a height and a wall thickness, m."""
        # The outer faces of the boxes are tangent to the outer circle, and neighbours meet at their
        # outer corners. The inner faces are tangent to the bore, which stays free.
        bore, across = radius - wall, radius * math.tan(math.pi / _SIDES)
        side = cls("box", (wall / 2, across, height / 2))
        walls = []
        for angle in (2 * math.pi * number / _SIDES for number in range(_SIDES)):
            x, y = math.cos(angle), math.sin(angle)
            middle = bore + wall / 2
            walls.append(Wall(side, UrdfOrigin((middle * x, middle * y, 0.0), (0.0, 0.0, angle))))
        return cls("cylinder", (radius, radius, height / 2), walls=tuple(walls))

    @classmethod
    def open_box(cls, depth: float, width: float, height: float, wall: float) -> SolidShape:
        """Return an open box of outer edges along x, y and z and a wall thickness, m."""
        x, y, z, half = depth / 2, width / 2, height / 2, wall / 2
        bottom = Wall(cls("box", (x, y, half)), UrdfOrigin((0.0, 0.0, half - z)))
        front, side = (half, y, z - half), (x - wall, half, z - half)
        walls = [
            Wall(cls("box", halves), UrdfOrigin((a, b, half)))
            for halves, a, b in (
                # Front and back have the full width, and the sides fit between them.
                (front, half - x, 0.0),
                (front, x - half, 0.0),
                (side, 0.0, half - y),
                (side, 0.0, y - half),
            )
        ]
        return cls("box", (x, y, z), walls=(bottom, *walls))

    @classmethod
    def composed(cls, form: ComposedForm) -> SolidShape:
        """Return several solids as one shape, in the middle of the box around them."""
        middle = [(first + last) / 2 for first, last in form.box]
        x, y, z = ((last - first) / 2 for first, last in form.box)
        return cls("box", (x, y, z), walls=tuple(_wall(piece, middle) for piece in form.pieces))

    @classmethod
    def meshed(cls, file: Path, scale: float, solid: str) -> SolidShape:
        """Return a mesh with its colliding solid.

        Args:
            file: File of the mesh.
            scale: Scale of its unit, m.
            solid: Kind of the colliding solid, as in ``MeshForm``.

        Raises:
            UsageError: The file is missing, or holds no mesh of a thing.
        """
        mesh, halves = read_thing_mesh(file, scale)
        x, y, z = halves
        match solid:
            case "ball":
                radius = max(halves)
                return cls("ball", (radius, radius, radius), mesh=mesh)
            case "cylinder":
                radius = max(x, y)
                return cls("cylinder", (radius, radius, z), mesh=mesh)
            case "box":
                return cls("box", halves, mesh=mesh)
            case "boxes":
                triangles = mesh.corners[mesh.triangles]
                return cls("box", halves, walls=_filling(triangles), mesh=mesh)
        from cbdsl.numeric.convex_hull import hull_corners, hull_faces  # few things have a hull

        corners = hull_corners(mesh.corners)
        walls = _filling(corners[hull_faces(corners)])
        return cls("box", halves, walls=walls, mesh=mesh, hull=corners)

    @classmethod
    def draw(cls, form: Form, rng: np.random.Generator) -> SolidShape:
        """Return a shape of a form, of a size drawn from its spans."""
        if isinstance(form, BallForm):
            return cls.ball(draw(form.radius, rng), form.all_spots)
        if isinstance(form, BoxForm):
            x, y, z = (draw(span, rng) / 2 for span in form.size)
            return cls("box", (x, y, z), form.pattern, form.all_spots)
        if isinstance(form, OpenBoxForm):
            depth, width, height = (draw(span, rng) for span in form.size)
            return cls.open_box(depth, width, height, form.wall)
        if isinstance(form, ComposedForm):
            return cls.composed(form)
        if isinstance(form, MeshForm):
            return _meshed(form.path, form.scale, form.solid, changed(form.path))
        radius, height = draw(form.radius, rng), draw(form.height, rng)
        if isinstance(form, TubeForm):
            return cls.tube(radius, height, form.wall)
        return cls.cylinder(radius, height, form.all_spots)

    @property
    def solids(self) -> tuple[Wall, ...]:
        """Solids that the shape consists of: its walls, or itself."""
        return self.walls or (Wall(self, UrdfOrigin()),)

    @property
    def half_height(self) -> float:
        """Distance from the centre to the lowest point of the upright shape, m."""
        return self.halves[2]

    @property
    def volume(self) -> float:
        """Volume of the shape, or of its walls, m^3."""
        if self.walls:
            return sum(wall.shape.volume for wall in self.walls)
        share = {"ball": math.pi / 6, "box": 1.0, "cylinder": math.pi / 4}[self.kind]
        return share * 8 * math.prod(self.halves)

    def spot_height(self, spot: Spot) -> float:
        """Return the distance from the centre to a spot's edge, along its axis, m.

        The edge on a cylinder is not in one plane; the shortest distance counts.
        """
        if self.kind in ("ball", "cylinder"):
            return math.sqrt(self.halves[0] ** 2 - spot.radius**2)
        return self.halves["xy".index(spot.face[1])]

    def depth(self, rotation: Floats) -> float:
        """Return the distance from centre to lowest point with these axes, shape (3, 3), m."""
        a, b, c = self.halves
        if self.kind == "ball":
            return a
        # Support function of the shape along the world's z: the third row has the z components of
        # its axes.
        x, y, z = np.abs(rotation[2]).tolist()
        if self.kind == "cylinder":
            return float(a * np.hypot(x, y) + c * z)
        return float(a * x + b * y + c * z)

    def bodies(self, pose: Pose) -> list[Convex]:
        """Return the convex bodies that the shape consists of at a pose."""
        if self.hull is not None:
            return [Convex("hull", self.halves, pose.position, pose.rotation, self.hull)]
        frames = [(wall.shape, pose @ Pose.at(wall.origin)) for wall in self.solids]
        return [Convex(shape.kind, shape.halves, at.position, at.rotation) for shape, at in frames]


def _wall(piece: Piece, middle: Sequence[float]) -> Wall:
    """Return a piece of a composed shape, in a frame in the middle of that shape."""
    x, y, z = (own - mean for own, mean in zip(piece.position, middle, strict=True))
    origin = UrdfOrigin((x, y, z), (0.0, 0.0, piece.yaw))
    if isinstance(piece.form, BoxForm):
        return Wall(SolidShape("box", piece.halves), origin)
    if isinstance(piece.form, CylinderForm):
        return Wall(SolidShape("cylinder", piece.halves), origin)
    return Wall(SolidShape("ball", piece.halves), origin)


@lru_cache(maxsize=16)  # each episode draws its things again
def _meshed(file: Path, scale: float, solid: str, _changed: int) -> SolidShape:
    return SolidShape.meshed(file, scale, solid)


def _filling(triangles: Floats) -> tuple[Wall, ...]:
    """Return boxes that fill a closed surface."""
    boxes = cover(triangles, MOST_PIECES).boxes
    return tuple(
        Wall(SolidShape("box", (a / 2, b / 2, c / 2)), UrdfOrigin((x, y, z)))
        for (x, y, z), (a, b, c) in boxes.tolist()
    )
