"""Shapes as MuJoCo's geoms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import (
    BackendError,
    MeshError,
    SolidShape,
    UrdfShape,
    find_mesh,
    read_mesh_file,
)

_KINDS = {
    "ball": mj.mjtGeom.mjGEOM_SPHERE,
    "box": mj.mjtGeom.mjGEOM_BOX,
    "cylinder": mj.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mj.mjtGeom.mjGEOM_CAPSULE,
}
# Colour of the robot in the simulator's window.
_GREY = (0.7, 0.7, 0.7)
# Largest number of corners of a convex hull; more cost time and hardly improve contacts.
_MOST_CORNERS = 64
# Singular value below which all corners are in a plane, m.
_FLATTEST = 1e-6
# Number of extents of each kind.
_EXTENTS = {"ball": 1, "box": 3, "cylinder": 2, "capsule": 2}


def add_shape(spec: Any, body: Any, shape: UrdfShape, name: str, urdf: Path) -> Any:
    """Add a colliding shape of the robot's model, named ``link/number``, to the link's body.

    A mesh collides as its convex hull, as in most engines.

    Raises:
        BackendError: The shape is a mesh that cannot be read, or a kind that MuJoCo does not have.
    """
    link = name.rpartition("/")[0]
    place = {"name": name, "rgba": [*_GREY, 1.0], **_placement(shape)}
    if shape.kind == "mesh":
        hull = _add_hull(spec, shape, urdf, link)
        return body.add_geom(type=mj.mjtGeom.mjGEOM_MESH, meshname=hull, **place)
    if shape.kind not in _KINDS:
        raise BackendError(f"{urdf.name}: link '{link}' has a {shape.kind} to collide with")
    a, b, c = (*shape.size, 0.0, 0.0)[:3]
    size = [a / 2, b / 2, c / 2] if shape.kind == "box" else [a, b / 2, 0.0]
    if any(extent <= 0.0 for extent in size[: _EXTENTS[shape.kind]]):
        raise BackendError(f"{urdf.name}: link '{link}' has a {shape.kind} without extent")
    return body.add_geom(type=_KINDS[shape.kind], size=size, **place)


def _placement(shape: UrdfShape) -> dict[str, Any]:
    x, y, z, w = shape.origin.quaternion
    return {"pos": shape.origin.xyz, "quat": [w, x, y, z]}


def _add_hull(spec: Any, shape: UrdfShape, urdf: Path, link: str) -> str:
    """Add the hull of a mesh to the specification if it is missing; return its name."""
    name = f"{shape.file} {shape.size}"
    if spec.mesh(name) is not None:
        return name
    file = find_mesh(shape.file, urdf.parent)
    if file is None:
        raise BackendError(
            f"{urdf.name}: link '{link}' collides as the mesh {shape.file}, which is not there"
        )
    try:
        corners = read_mesh_file(file, shape.size).corners
    except MeshError as error:
        raise BackendError(f"{urdf.name}: link '{link}' has a broken mesh: {error}") from error
    corners = np.unique(corners, axis=0)
    spread = corners - corners.mean(axis=0)
    # A hull needs volume. A model's plate or decal may be a mesh in one plane.
    if np.linalg.matrix_rank(spread, tol=_FLATTEST) < 3:
        raise BackendError(
            f"{urdf.name}: link '{link}' collides as the mesh {shape.file}, which is flat"
        )
    spec.add_mesh(name=name, uservert=corners.ravel(), maxhullvert=_MOST_CORNERS)
    return name


def add_solids(spec: Any, body: Any, shape: SolidShape, mass: float) -> list[Any]:
    """Add the solids of an object to its body; walls share its mass by their volumes.

    Args:
        spec: Specification of the world, which takes the corners of a hull.
        body: Body of the object.
        shape: Shape of the object.
        mass: Mass, kg.
    """
    if shape.hull is not None:
        name = f"{body.name}/hull"
        spec.add_mesh(name=name, uservert=shape.hull.ravel())
        kind = mj.mjtGeom.mjGEOM_MESH
        return [body.add_geom(type=kind, meshname=name, mass=mass)]
    solids = shape.solids
    volumes = [wall.shape.volume for wall in solids]
    geoms = []
    for wall, volume in zip(solids, volumes, strict=True):
        a, b, c = wall.shape.halves
        kind = wall.shape.kind
        size = {"ball": [a, 0.0, 0.0], "box": [a, b, c], "cylinder": [a, c, 0.0]}[kind]
        x, y, z, w = wall.origin.quaternion
        place = {"pos": wall.origin.xyz, "quat": [w, x, y, z]}
        # All walls have the same density, so that a hollow object has its centre of mass in the
        # middle of its material.
        share = mass * volume / sum(volumes)
        geoms.append(body.add_geom(type=_KINDS[kind], size=size, mass=share, **place))
    return geoms
