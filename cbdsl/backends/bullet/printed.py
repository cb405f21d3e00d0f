"""Balls and boxes with something printed or painted on a side."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pybullet as p

from cbdsl.backends.staging.shape import Shape
from cbdsl.documents.stage import Pattern, Spot

Triple = Sequence[float]

# How far the print stands out of the side, so that what is in front of what stays clear, m.
_THICKNESS = 1e-4
# A ball's spot is part of a larger curvature: this share of the radius nearer to the side.
_RAISED = 0.05
_BLACK = (0.0, 0.0, 0.0)
_NORMALS = {"-x": (-1, 0, 0), "+x": (1, 0, 0), "-y": (0, -1, 0), "+y": (0, 1, 0)}


def create_printed(
    client: int,
    shape: Shape,
    mass: float,
    color: Triple,
    position: Triple,
    quaternion: Triple,
) -> int:
    """Put a ball or box into the world, with what is printed or painted on a side.

    The simulator's own calls make bodies of 16 shapes at most, while a URDF may have any number.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "thing.urdf"
        path.write_text(_urdf(shape, mass, color), encoding="utf-8")
        return int(
            p.loadURDF(
                str(path), list(position), list(quaternion), useFixedBase=0, physicsClientId=client
            )
        )


def _urdf(shape: Shape, mass: float, color: Triple) -> str:
    body = _body(shape)
    lines = [
        '<robot name="thing"><link name="thing">',
        # The simulator derives the inertia from the shape, whatever is written here.
        f'<inertial><mass value="{mass:.9g}"/>',
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>',
        f"<collision><geometry>{body}</geometry></collision>",
        _visual("thing", (0, 0, 0), body, color),
    ]
    if shape.pattern is not None:
        lines += [
            _visual(f"bar_{i}", centre, _box(size), _BLACK)
            for i, (centre, size) in enumerate(_bars(shape.halves, shape.pattern))
        ]
    if shape.spot is not None:
        lines.append(_painted(shape, shape.spot))
    # The simulator's reader stumbles over long lines.
    return "\n".join([*lines, "</link></robot>"])


def _body(shape: Shape) -> str:
    if shape.kind == "ball":
        return _ball(shape.halves[0])
    return _box([2 * half for half in shape.halves])


def _painted(shape: Shape, spot: Spot) -> str:
    """A spot: of a ball the part of another ball that stands out of it, of a box a disc."""
    normal, height = np.array(_NORMALS[spot.face], dtype=np.float64), shape.spot_height()
    if shape.kind == "ball":
        raised = _RAISED * shape.halves[0]
        curved = _ball(math.hypot(spot.radius, height - raised))
        return _visual("spot", (raised * normal).tolist(), curved, spot.color)
    disc = f'<cylinder radius="{spot.radius:.9g}" length="{2 * _THICKNESS:.9g}"/>'
    # A cylinder stands along z.
    turned = (0.0, math.pi / 2, 0.0) if spot.face.endswith("x") else (math.pi / 2, 0.0, 0.0)
    return _visual("spot", (height * normal).tolist(), disc, spot.color, turned)


def _bars(halves: Triple, pattern: Pattern) -> Iterator[tuple[Triple, Triple]]:
    """Centre and edge lengths of each bar in the box's frame, m."""
    normal = np.array(_NORMALS[pattern.face], dtype=np.float64)
    right = np.cross([0.0, 0.0, 1.0], normal)
    edges = np.cumsum([0.0, *pattern.stripes]) - sum(pattern.stripes) / 2
    for left, width in zip(edges[:-1:2], pattern.stripes[::2], strict=True):
        centre = np.abs(normal) @ np.array(halves) * normal + (left + width / 2) * right
        size = 2 * _THICKNESS * np.abs(normal) + width * np.abs(right)
        yield centre.tolist(), [*size.tolist()[:2], pattern.height]


def _visual(
    name: str, centre: Triple, geometry: str, color: Triple, turned: Triple = (0, 0, 0)
) -> str:
    return (
        f'<visual><origin xyz="{_numbers(centre)}" rpy="{_numbers(turned)}"/>'
        f"<geometry>{geometry}</geometry>"
        f'<material name="{name}"><color rgba="{_numbers(color)} 1"/></material></visual>'
    )


def _ball(radius: float) -> str:
    return f'<sphere radius="{radius:.9g}"/>'


def _box(edges: Triple) -> str:
    return f'<box size="{_numbers(edges)}"/>'


def _numbers(values: Triple) -> str:
    return " ".join(f"{value:.9g}" for value in values)
