"""Shapes as MuJoCo's geoms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco as mj

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.robot.urdf import UrdfShape

_KINDS = {
    "ball": mj.mjtGeom.mjGEOM_SPHERE,
    "box": mj.mjtGeom.mjGEOM_BOX,
    "cylinder": mj.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mj.mjtGeom.mjGEOM_CAPSULE,
}


def add_shape(spec: Any, body: Any, shape: UrdfShape, name: str, urdf: Path) -> Any:
    """Add a colliding shape of the robot's model to a body.

    Raises:
        BackendError: it is a mesh, or a shape that MuJoCo does not know.
    """
    if shape.kind not in _KINDS:
        raise BackendError(f"{urdf.name}: link '{body.name}' has a {shape.kind} to collide with")
    x, y, z, w = shape.origin.quaternion
    a, b, c = (*shape.size, 0.0, 0.0)[:3]
    size = [a / 2, b / 2, c / 2] if shape.kind == "box" else [a, b / 2, 0.0]
    place = {"pos": shape.origin.xyz, "quat": [w, x, y, z]}
    return body.add_geom(name=name, type=_KINDS[shape.kind], size=size, **place)


def add_solids(body: Any, shape: SolidShape, mass: float) -> list[Any]:
    """Add what an object is made of to its body; walls share its mass by their volumes."""
    solids = shape.solids
    volumes = [wall.shape.volume for wall in solids]
    geoms = []
    for wall, volume in zip(solids, volumes, strict=True):
        a, b, c = wall.shape.halves
        kind = wall.shape.kind
        size = {"ball": [a, 0.0, 0.0], "box": [a, b, c], "cylinder": [a, c, 0.0]}[kind]
        x, y, z, w = wall.origin.quaternion
        place = {"pos": wall.origin.xyz, "quat": [w, x, y, z]}
        share = mass * volume / sum(volumes)
        geoms.append(body.add_geom(type=_KINDS[kind], size=size, mass=share, **place))
    return geoms
