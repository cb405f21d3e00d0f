"""Boxes with bars printed on a side."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pybullet as p

from cbdsl.documents.stage import Pattern

Triple = Sequence[float]

# How far the print stands out of the side, so that what is in front of what stays clear, m.
_THICKNESS = 1e-4
_BLACK = (0.0, 0.0, 0.0)
_NORMALS = {"-x": (-1, 0, 0), "+x": (1, 0, 0), "-y": (0, -1, 0), "+y": (0, 1, 0)}


def create_printed_box(
    client: int,
    halves: Triple,
    pattern: Pattern,
    mass: float,
    color: Triple,
    position: Triple,
    quaternion: Triple,
) -> int:
    """Put a box into the world, with half edges ``halves``, m, and this pattern on a side.

    The simulator's own calls make bodies of 16 shapes at most, while a URDF may have any number.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "box.urdf"
        path.write_text(_urdf(halves, pattern, mass, color), encoding="utf-8")
        return int(
            p.loadURDF(
                str(path), list(position), list(quaternion), useFixedBase=0, physicsClientId=client
            )
        )


def _urdf(halves: Triple, pattern: Pattern, mass: float, color: Triple) -> str:
    edges = [2 * half for half in halves]
    lines = [
        '<robot name="box"><link name="box">',
        # The simulator derives the inertia from the shape, whatever is written here.
        f'<inertial><mass value="{mass:.9g}"/>',
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>',
        f'<collision><geometry><box size="{_numbers(edges)}"/></geometry></collision>',
        _visual("box", (0, 0, 0), edges, color),
        *(
            _visual(f"bar_{i}", centre, size, _BLACK)
            for i, (centre, size) in enumerate(_bars(halves, pattern))
        ),
        "</link></robot>",
    ]
    # The simulator's reader stumbles over long lines.
    return "\n".join(lines)


def _bars(halves: Triple, pattern: Pattern) -> Iterator[tuple[Triple, Triple]]:
    """Centre and edge lengths of each bar in the box's frame, m."""
    normal = np.array(_NORMALS[pattern.face], dtype=np.float64)
    right = np.cross([0.0, 0.0, 1.0], normal)
    edges = np.cumsum([0.0, *pattern.stripes]) - sum(pattern.stripes) / 2
    for left, width in zip(edges[:-1:2], pattern.stripes[::2], strict=True):
        centre = np.abs(normal) @ np.array(halves) * normal + (left + width / 2) * right
        size = 2 * _THICKNESS * np.abs(normal) + width * np.abs(right)
        yield centre.tolist(), [*size.tolist()[:2], pattern.height]


def _visual(name: str, centre: Triple, size: Triple, color: Triple) -> str:
    return (
        f'<visual><origin xyz="{_numbers(centre)}"/>'
        f'<geometry><box size="{_numbers(size)}"/></geometry>'
        f'<material name="{name}"><color rgba="{_numbers(color)} 1"/></material></visual>'
    )


def _numbers(values: Triple) -> str:
    return " ".join(f"{value:.9g}" for value in values)
