"""Meshes of robots, made small enough for a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Triangles = NDArray[np.intp]

# Enough to know a link by its shape; a robot of 30 links then takes half a megabyte.
_MOST_TRIANGLES = 1500
_FINEST = 64


class Mesh(NamedTuple):
    """Triangles.

    Attributes:
        corners: m, shape (corners, 3).
        triangles: indices of their corners, shape (triangles, 3).
    """

    corners: Floats
    triangles: Triangles


def read_mesh(file: Path, scale: Sequence[float]) -> Mesh | None:
    """The mesh in a file with its corners times ``scale``, simplified; ``None`` if unreadable."""
    try:
        # Pinocchio brings it along; it reads every format that Pinocchio does.
        import coal
    except ImportError:
        return None
    try:
        loaded: Any = coal.MeshLoader().load(str(file), np.array(scale, dtype=float))
        corners = np.array(loaded.vertices())
        rows = [loaded.tri_indices(index) for index in range(loaded.num_tris)]
    except (RuntimeError, ValueError):
        return None
    triangles = np.array([[row[0], row[1], row[2]] for row in rows], dtype=np.intp).reshape(-1, 3)
    return simplified(Mesh(corners, triangles)) if len(triangles) else None


def simplified(mesh: Mesh) -> Mesh:
    """The mesh with corners that are close together merged, until it is small enough."""
    cells = _FINEST
    small = _merged(mesh, cells)
    while len(small.triangles) > _MOST_TRIANGLES:
        cells = cells * 3 // 4
        small = _merged(mesh, cells)
    return small


def _merged(mesh: Mesh, cells: int) -> Mesh:
    """Every corner becomes the mean of those in its cell, of ``cells`` along the longest edge."""
    lowest = mesh.corners.min(axis=0)
    size = float((mesh.corners.max(axis=0) - lowest).max()) / cells or 1.0
    places = np.floor((mesh.corners - lowest) / size).astype(np.intp)
    _, cell, count = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    cell = cell.reshape(-1)
    corners = np.zeros((len(count), 3))
    np.add.at(corners, cell, mesh.corners)
    triangles = cell[mesh.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    return Mesh(corners / count[:, None], np.unique(triangles, axis=0))
