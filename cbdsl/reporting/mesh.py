"""Meshes of robots, made small enough for a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cbdsl.robot.mesh_reader import Mesh, MeshError, read_mesh_file
from cbdsl.robot.simplified_mesh import simplified


def read_mesh(file: Path, scale: Sequence[float]) -> Mesh | None:
    """The mesh in a file with its corners times ``scale``, simplified; ``None`` if unreadable."""
    try:
        return simplified(read_mesh_file(file, scale))
    except MeshError:
        return None
