"""Meshes of objects, in the middle of the box around them."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.diagnostics.errors import UsageError
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.meshes.mesh_reader import Mesh
from cbdsl.robot.meshes.triangles import read_triangles
from cbdsl.storage.contents import is_file

# Smallest volume relative to the cube of the longest extent; smaller meshes count as flat.
_LEAST = 1e-6


class ThingMesh(NamedTuple):
    """Closed mesh in the middle of the box around it.

    Attributes:
        mesh: Corners, m, and triangles.
        halves: Half extents along x, y and z, m.
    """

    mesh: Mesh
    halves: tuple[float, float, float]


def read_thing_mesh(file: Path, scale: float) -> ThingMesh:
    """Return the mesh in a file with a unit of ``scale`` metres, read again after changes.

    Raises:
        UsageError: If there is no such file, or it is not a mesh of an object of graspable size.
    """
    return _read(file, scale, changed(file))


def changed(file: Path) -> int:
    """Return the time of a file's last change, ns; 0 if it is missing."""
    return file.stat().st_mtime_ns if is_file(file) else 0


@lru_cache(maxsize=32)
def _read(file: Path, scale: float, _changed: int) -> ThingMesh:
    triangles = read_triangles(file, scale)
    a, b, c = np.moveaxis(triangles, 1, 0)
    # Each triangle and the origin form a tetrahedron with the signed volume a . (b x c) / 6. Over a
    # closed mesh these sum up to its volume, for any origin (divergence theorem). The sign is
    # positive if the corners run counter-clockwise seen from outside. The reader has already
    # refused meshes that are not closed.
    volume = float(np.sum(a * np.cross(b, c))) / 6
    if abs(volume) < _LEAST * float(np.ptp(triangles.reshape(-1, 3), axis=0).max()) ** 3:
        raise UsageError(f"{file}: it has no inside")
    if volume < 0:  # its triangles face inwards
        triangles = triangles[:, ::-1]
    corners, places = _distinct(triangles.reshape(-1, 3))
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y, z = ((high - low) / 2).tolist()
    mesh = Mesh(corners - (low + high) / 2, places.reshape(-1, 3).astype(np.intp))
    return ThingMesh(mesh, (x, y, z))


def _distinct(rows: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the sorted distinct rows, and the place of each row among them.

    ``np.unique`` of rows does the same in ten times the time.
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    is_new = np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)])
    places = np.empty(len(rows), np.intp)
    places[order] = np.cumsum(is_new) - 1
    return ordered[is_new], places
