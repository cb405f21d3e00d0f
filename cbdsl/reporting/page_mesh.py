"""Meshes of robots, made small enough for a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cbdsl.robot.meshes.mesh_reader import Mesh, MeshError, read_mesh_file
from cbdsl.robot.meshes.simplified_mesh import simplified


def read_mesh(file: Path, scale: Sequence[float]) -> Mesh | None:
    """Return a simplified mesh from a file, scaled by ``scale``, or ``None`` if unreadable."""
    try:
        return simplified(read_mesh_file(file, scale))
    except MeshError:
        return None
