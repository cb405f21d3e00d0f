"""Meshes of things, in the middle of the box around them."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cbdsl.robot.mesh_reader import Mesh
from cbdsl.robot.triangles import read_triangles


class ThingMesh(NamedTuple):
    """A closed mesh in the middle of the box around it.

    Attributes:
        mesh: its corners, m, and triangles.
        halves: half its extents along x, y and z, m.
    """

    mesh: Mesh
    halves: tuple[float, float, float]


def read_thing_mesh(file: Path, scale: float) -> ThingMesh:
    """The mesh in a file, of a unit of ``scale`` metres; read again once the file has changed.

    Raises:
        UsageError: there is no such file, it is no mesh, or none of a thing that a hand could hold.
    """
    return _read(file, scale, changed(file))


def changed(file: Path) -> int:
    """When a file was last changed, ns; 0 where it is not there."""
    return file.stat().st_mtime_ns if file.is_file() else 0


@lru_cache(maxsize=32)
def _read(file: Path, scale: float, _changed: int) -> ThingMesh:
    triangles = read_triangles(file, scale)
    a, b, c = np.moveaxis(triangles, 1, 0)
    if np.sum(a * np.cross(b, c)) < 0:  # its triangles are seen from the inside
        triangles = triangles[:, ::-1]
    corners, places = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y, z = ((high - low) / 2).tolist()
    mesh = Mesh(corners - (low + high) / 2, places.reshape(-1, 3).astype(np.intp))
    return ThingMesh(mesh, (x, y, z))
