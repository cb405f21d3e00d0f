"""Appearance of scene objects: shapes, and prints or painted spots on their sides."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.backends.staging.world_state import Part
from cbdsl.documents.form import Pattern, Spot
from cbdsl.robot.urdf import UrdfOrigin

# Height of a print above its side, so that the depth order stays unambiguous, m.
_THICKNESS = 1e-4
# Share of the radius by which a ball's spot is nearer to the side, as part of another ball.
_RAISED = 0.05
_BLACK = (0.0, 0.0, 0.0)
_CENTRE, _UNTURNED = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
_NORMALS = {"-x": (-1, 0, 0), "+x": (1, 0, 0), "-y": (0, -1, 0), "+y": (0, 1, 0)}
#: Rotations that lay a cylinder, which stands along z, along x or y.
LYING = {
    "x": UrdfOrigin(rpy=(0.0, math.pi / 2, 0.0)),
    "y": UrdfOrigin(rpy=(math.pi / 2, 0.0, 0.0)),
}


def parts_of(item: SceneObject) -> list[Part]:
    """Return the visible parts of an object: first its solids, then its print or spots."""
    shape = item.shape
    color = tuple(item.surface.color)
    if shape.mesh is not None:
        return [Part("mesh", (), _CENTRE, _UNTURNED, color, shape.mesh)]
    parts = solid_parts(shape, color)
    if shape.pattern is not None:
        parts += _bars(shape.halves, shape.pattern)
    parts += [_spot(shape, spot) for spot in shape.spots]
    return parts


def solid_parts(shape: SolidShape, color: tuple[float, ...]) -> list[Part]:
    """Return the parts that a shape consists of, visible or not."""
    return [
        Part(wall.shape.kind, _size(wall.shape), wall.origin.xyz, wall.origin.quaternion, color)
        for wall in shape.solids
    ]


def _size(shape: SolidShape) -> tuple[float, ...]:
    """Return the size of a shape as in ``Part``."""
    a, b, c = shape.halves
    if shape.kind == "ball":
        return (a,)
    return (2 * a, 2 * b, 2 * c) if shape.kind == "box" else (a, 2 * c)


def _spot(shape: SolidShape, spot: Spot) -> Part:
    """Return a spot: on a ball, the protruding part of another ball; on a box, a disc."""
    normal, height = np.array(_NORMALS[spot.face], dtype=np.float64), shape.spot_height(spot)
    if shape.kind == "ball":
        # The spot's edge is a circle of the radius s at the height h. Another ball through the same
        # circle, with its centre raised by c, has the radius sqrt(s^2 + (h - c)^2). It protrudes
        # beyond the edge only.
        raised = _RAISED * shape.halves[0]
        size, centre = math.hypot(spot.radius, height - raised), raised * normal
        return Part("ball", (size,), tuple(centre.tolist()), _UNTURNED, spot.color)
    turned, centre = LYING[spot.face[1]].quaternion, height * normal
    size = 2 * _THICKNESS
    return Part("cylinder", (spot.radius, size), tuple(centre.tolist()), turned, spot.color)


def _bars(halves: Sequence[float], pattern: Pattern) -> Iterator[Part]:
    normal = np.array(_NORMALS[pattern.face], dtype=np.float64)
    # To the right of a viewer who faces the side. Stripes alternate: bar, gap, bar.
    right = np.cross([0.0, 0.0, 1.0], normal)
    edges = np.cumsum([0.0, *pattern.stripes]) - sum(pattern.stripes) / 2
    for left, width in zip(edges[:-1:2], pattern.stripes[::2], strict=True):
        centre = np.abs(normal) @ np.array(halves) * normal + (left + width / 2) * right
        level = 2 * _THICKNESS * np.abs(normal) + width * np.abs(right)
        size = (*level.tolist()[:2], pattern.height)
        yield Part("box", size, tuple(centre.tolist()), _UNTURNED, _BLACK)
