"""Objects of several parts: hollow ones, meshes, and those with a print or a spot on a side."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.staging.appearance import LYING, parts_of, solid_parts
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.world_state import Part
from cbdsl.numeric.convex_hull import hull_faces
from cbdsl.robot.meshes.mesh_reader import Mesh

# Files of the visible mesh, and of the colliding hull.
_SEEN, _HULL = "seen.obj", "hull.obj"
# URDF writes rotations as angles; all rotations that are not listed here are about z.
_ANGLES = {origin.quaternion: origin.rpy for origin in LYING.values()}


def create_composed(client: int, item: SceneObject) -> int:
    """Create a hollow object, a mesh, or an object with a print or a spot on a side.

    The simulator's own calls make bodies of 16 shapes at most, while a URDF may have any number.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "thing.urdf"
        _write_meshes(item, Path(folder))
        # The simulator's reader stumbles over long lines.
        path.write_text("\n".join(_lines(item)), encoding="utf-8")
        position, quaternion = item.pose.position.tolist(), list(item.pose.quaternion())
        return int(
            p.loadURDF(
                str(path),
                position,
                quaternion,
                useFixedBase=item.mass == 0.0,
                # Otherwise a lone cylinder becomes a hull, whose inertia is that of a box.
                flags=0 if item.shape.walls else p.URDF_USE_IMPLICIT_CYLINDER,
                physicsClientId=client,
            )
        )


def _lines(item: SceneObject) -> Iterator[str]:
    parts = parts_of(item)
    yield '<robot name="thing"><link name="thing">'
    # The simulator derives the inertia from the shape and ignores these values.
    yield f'<inertial><mass value="{item.mass:.9g}"/>'
    yield '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    if item.shape.hull is not None:
        # The simulator takes the convex hull of a collision mesh.
        yield f'<collision><geometry><mesh filename="{_HULL}"/></geometry></collision>'
    else:
        solid = solid_parts(item.shape, ())
        yield from (f"<collision>{_origin(part)}{_geometry(part)}</collision>" for part in solid)
    yield from (_visual(f"part_{number}", part) for number, part in enumerate(parts))
    yield "</link></robot>"


def _write_meshes(item: SceneObject, folder: Path) -> None:
    """Write the files that the object's URDF names."""
    mesh, hull = item.shape.mesh, item.shape.hull
    if mesh is not None:
        _write_mesh(folder / _SEEN, mesh)
    if hull is not None:
        _write_mesh(folder / _HULL, Mesh(hull, hull_faces(hull)))


def _write_mesh(file: Path, mesh: Mesh) -> None:
    """Write an OBJ, with a normal for each triangle."""
    a, b, c = np.moveaxis(mesh.corners[mesh.triangles], 1, 0)
    normals: NDArray[np.float64] = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in mesh.corners.tolist()]
    lines += [f"vn {x:.6f} {y:.6f} {z:.6f}" for x, y, z in normals.tolist()]
    faces = enumerate((mesh.triangles + 1).tolist(), 1)
    lines += [f"f {i}//{n} {j}//{n} {k}//{n}" for n, (i, j, k) in faces]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _visual(name: str, part: Part) -> str:
    return (
        f"<visual>{_origin(part)}{_geometry(part)}"
        f'<material name="{name}"><color rgba="{_numbers(part.color)} 1"/></material></visual>'
    )


def _origin(part: Part) -> str:
    *_, z, w = part.quaternion
    # A rotation about z by the angle t has the quaternion (0, 0, sin(t/2), cos(t/2)).
    angles = _ANGLES.get(part.quaternion, (0.0, 0.0, 2 * math.atan2(z, w)))
    return f'<origin xyz="{_numbers(part.position)}" rpy="{_numbers(angles)}"/>'


def _geometry(part: Part) -> str:
    if part.shape == "box":
        return f'<geometry><box size="{_numbers(part.size)}"/></geometry>'
    if part.shape == "ball":
        return f'<geometry><sphere radius="{part.size[0]:.9g}"/></geometry>'
    if part.shape == "mesh":
        return f'<geometry><mesh filename="{_SEEN}"/></geometry>'
    radius, length = part.size
    return f'<geometry><cylinder radius="{radius:.9g}" length="{length:.9g}"/></geometry>'


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)
