"""Objects of several parts: hollow ones, and those with a print or a spot on a side."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import pybullet as p

from cbdsl.backends.staging.appearance import LYING, parts_of
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.world_state import Part

# URDF writes rotations as angles; what is not among these is turned about z.
_ANGLES = {origin.quaternion: origin.rpy for origin in LYING.values()}


def create_composed(client: int, item: SceneObject) -> int:
    """Put something hollow into the world, or with something printed or painted on a side.

    The simulator's own calls make bodies of 16 shapes at most, while a URDF may have any number.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "thing.urdf"
        # The simulator's reader stumbles over long lines.
        path.write_text("\n".join(_lines(item)), encoding="utf-8")
        position, quaternion = item.pose.position.tolist(), list(item.pose.quaternion())
        return int(
            p.loadURDF(
                str(path),
                position,
                quaternion,
                useFixedBase=item.mass == 0.0,
                physicsClientId=client,
            )
        )


def _lines(item: SceneObject) -> Iterator[str]:
    parts = parts_of(item)
    yield '<robot name="thing"><link name="thing">'
    # The simulator derives the inertia from the shape, whatever is written here.
    yield f'<inertial><mass value="{item.mass:.9g}"/>'
    yield '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    solid = parts[: len(item.shape.solids)]
    yield from (f"<collision>{_origin(part)}{_geometry(part)}</collision>" for part in solid)
    yield from (_visual(f"part_{number}", part) for number, part in enumerate(parts))
    yield "</link></robot>"


def _visual(name: str, part: Part) -> str:
    return (
        f"<visual>{_origin(part)}{_geometry(part)}"
        f'<material name="{name}"><color rgba="{_numbers(part.color)} 1"/></material></visual>'
    )


def _origin(part: Part) -> str:
    *_, z, w = part.quaternion
    angles = _ANGLES.get(part.quaternion, (0.0, 0.0, 2 * math.atan2(z, w)))
    return f'<origin xyz="{_numbers(part.position)}" rpy="{_numbers(angles)}"/>'


def _geometry(part: Part) -> str:
    if part.shape == "box":
        return f'<geometry><box size="{_numbers(part.size)}"/></geometry>'
    if part.shape == "ball":
        return f'<geometry><sphere radius="{part.size[0]:.9g}"/></geometry>'
    radius, length = part.size
    return f'<geometry><cylinder radius="{radius:.9g}" length="{length:.9g}"/></geometry>'


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)
