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
# Upright strips of which a spot on a cylinder consists, and their height above its side, m. Some
# renderers draw cylinders with corners a little outside of the side.
_STRIPS, _PROUD = 16, 5e-4
_BLACK = (0.0, 0.0, 0.0)
_CENTRE, _UNTURNED = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
_NORMALS = {"-x": (-1, 0, 0), "+x": (1, 0, 0), "-y": (0, -1, 0), "+y": (0, 1, 0)}
#: Rotations that lay a cylinder, which stands along z, along x or y.
LYING = {"x": UrdfOrigin(rpy=(0.0, math.pi / 2, 0.0)), "y": UrdfOrigin(rpy=(math.pi / 2, 0.0, 0.0))}


def parts_of(item: SceneObject) -> list[Part]:
    """Return the visible parts of an object: first its solids, then its print or spots."""
    shape = item.shape
    color = tuple(item.surface.color)
    if shape.mesh is not None:
        return [Part("mesh", (), _CENTRE, _UNTURNED, color, shape.mesh)]
    parts = solid_parts(shape, color)
    if shape.pattern is not None:
        parts += _bars(shape.halves, shape.pattern)
    for spot in shape.spots:
        parts += _strips(shape, spot) if shape.kind == "cylinder" else [_spot(shape, spot)]
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


def _strips(shape: SolidShape, spot: Spot) -> Iterator[Part]:
    """Yield the upright strips that show a spot on a cylinder.

    The spot covers the points of the side with y^2 + z^2 <= s^2, s being its radius and y the
    distance across its axis. On a cylinder of the radius r, y = r sin(t) at the angle t from the
    axis. A strip at the angle t is tangent to the side and reaches as far as the spot does there.
    """
    radius, normal = shape.halves[0], _NORMALS[spot.face]
    middle, reach = math.atan2(normal[1], normal[0]), math.asin(spot.radius / radius)
    step = 2 * reach / _STRIPS
    for number in range(_STRIPS):
        aside = (number + 0.5) * step - reach
        height = 2 * math.sqrt(spot.radius**2 - (radius * math.sin(aside)) ** 2)
        turn = middle + aside
        yield Part(
            "box",
            (2 * _PROUD, 2 * radius * math.tan(step / 2), height),
            (radius * math.cos(turn), radius * math.sin(turn), 0.0),
            (0.0, 0.0, math.sin(turn / 2), math.cos(turn / 2)),
            spot.color,
        )


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
