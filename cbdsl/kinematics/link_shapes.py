"""Convex shapes around the links of a robot, from the collision geometry of its model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cbdsl.kinematics.closest_points import closest_points
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.meshes.mesh_file import find_mesh
from cbdsl.robot.urdf import UrdfModel, UrdfShape

# Number of corners around a cylinder, of which each side touches it.
_SIDES = 12
# Deviation and number of corners at which the hull of a mesh is accurate enough, m.
_ACCURATE, _MOST_CORNERS = 0.003, 32


class ConvexShape(NamedTuple):
    """Hull of points, grown by a radius: a sphere of one point, a capsule of two, or more.

    Attributes:
        points: Points in the link's frame, m, shape (k, 3).
        radius: Radius, m.
        deviation: Largest distance of its surface beyond that of the geometry it covers, m.
    """

    points: Floats
    radius: float
    deviation: float = 0.0


def link_shapes(model: UrdfModel) -> Mapping[str, tuple[ConvexShape, ...]]:
    """Return shapes that cover the collision geometry of each link that has some.

    Cylinders become prisms of 12 sides, and meshes a part of the corners of their convex hull,
    grown until they cover it. Meshes that cannot be read are left out.

    Raises:
        UrdfError: If a value of a link is not a number.
    """
    folder = model.path.parent
    covered = {
        name: tuple(_cover(shape, folder) for shape in body.collisions if _has_volume(shape))
        for name, body in model.bodies.items()
    }
    return {name: shapes for name, own in covered.items() if (shapes := _known(own))}


def convex_hull(shape: UrdfShape, folder: Path) -> Any:
    """Return the convex hull of a mesh as geometry of coal; ``None`` if unreadable or flat.

    Raises:
        ImportError: If coal is not installed.
    """
    import coal  # installed with Pinocchio

    file = find_mesh(shape.file, folder)
    try:
        mesh = coal.MeshLoader().load(str(file), np.array(shape.size, dtype=float))
        mesh.buildConvexHull(True, "Qt")
    except (RuntimeError, ValueError):
        return None
    return mesh.convex


def _known(shapes: Sequence[ConvexShape | None]) -> tuple[ConvexShape, ...]:
    return tuple(shape for shape in shapes if shape is not None)


def _has_volume(shape: UrdfShape) -> bool:
    return shape.kind == "mesh" or all(size > 0 for size in shape.size)


def _cover(shape: UrdfShape, folder: Path) -> ConvexShape | None:
    """Return the shape that covers a geometry, in its link's frame."""
    size = shape.size
    if shape.kind == "mesh":
        hull = convex_hull(shape, folder)
        if hull is None:
            return None
        own = _simplified(np.array(hull.points()).reshape(-1, 3))
    elif shape.kind == "ball":
        own = ConvexShape(np.zeros((1, 3)), size[0])
    elif shape.kind == "box":
        own = ConvexShape(0.5 * np.array(size) * list(product((-1.0, 1.0), repeat=3)), 0.0)
    elif shape.kind == "capsule":
        own = ConvexShape(np.array([(0.0, 0.0, end * size[1] / 2) for end in (-1, 1)]), size[0])
    else:
        outer = size[0] / math.cos(math.pi / _SIDES)
        angles = np.arange(_SIDES) * 2 * math.pi / _SIDES
        round_ = np.stack([outer * np.cos(angles), outer * np.sin(angles)], axis=1)
        points = [(x, y, end * size[1] / 2) for end in (-1, 1) for x, y in round_]
        own = ConvexShape(np.array(points), 0.0, outer - size[0])
    at = Pose.at(shape.origin)
    return own._replace(points=own.points @ at.rotation.T + at.position)


def _simplified(corners: Floats) -> ConvexShape:
    """Return some corners (n, 3) of a hull, with the radius at which they cover the others.

    The corner farthest from the hull of the chosen ones is chosen next.
    """
    chosen = [int(np.argmax(np.linalg.norm(corners - corners.mean(axis=0), axis=1)))]
    while True:
        away = _distances(corners, corners[chosen])
        farthest = int(np.argmax(away))
        if away[farthest] <= _ACCURATE or len(chosen) == _MOST_CORNERS:
            radius = float(away[farthest])
            return ConvexShape(corners[chosen], radius, radius)
        chosen.append(farthest)


def _distances(corners: Floats, hull: Floats) -> Floats:
    """Return the distances of corners (n, 3) from a hull, shape (n,)."""
    points, ends = np.vstack([corners, hull]), np.zeros((2, 3))
    own, new = np.array((len(corners), len(points))), np.full((4, 2), -1)
    each = [
        closest_points(points, np.array((corner, corner + 1)), own, new.copy(), ends)
        for corner in range(len(corners))
    ]
    return np.array(each)
