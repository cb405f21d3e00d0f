"""Meshes of a robot that PyBullet cannot read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath

import pybullet as p

from cbdsl.backends.backend import BackendError
from cbdsl.robot.urdf import UrdfModel

_ENDINGS = (".obj", ".stl", ".dae")
_ALLOWED = "convert it to OBJ, binary STL or COLLADA, or use another engine"


def require_known_endings(model: UrdfModel) -> None:
    """Check the formats of the meshes of a model, which the simulator knows by their endings.

    Raises:
        BackendError: The simulator does not know one of the formats.
    """
    for file, link in model.meshes.items():
        if PurePosixPath(file).suffix.lower() not in _ENDINGS:
            raise BackendError(
                f"{model.path.name}: PyBullet does not read mesh '{file}' of link '{link}'; "
                f"{_ALLOWED}"
            )


def require_collisions(
    client: int, robot: int, model: UrdfModel, numbers: Mapping[str, int]
) -> None:
    """Check that the simulator has read the collision meshes of a robot.

    It leaves out a mesh that it cannot read, such as an STL in text, and only prints a warning.

    Args:
        client: Number of the simulator's connection.
        robot: The simulator's number of the robot.
        model: Model of the robot.
        numbers: The simulator's number of each link.

    Raises:
        BackendError: It has left one out.
    """
    for link, body in model.bodies.items():
        files = [shape.file for shape in body.collisions if shape.kind == "mesh"]
        if not files:
            continue
        rows = p.getCollisionShapeData(robot, numbers[link], physicsClientId=client)
        # A file may be read as more than one mesh, never as less than one.
        if sum(row[2] == p.GEOM_MESH for row in rows) < len(files):
            raise BackendError(
                f"{model.path.name}: PyBullet has no contacts for {_names(files)} of link "
                f"'{link}'; {_ALLOWED}"
            )


def _names(files: list[str]) -> str:
    return f"mesh '{files[0]}'" if len(files) == 1 else f"one of the meshes {', '.join(files)}"
