"""Simplification of meshes for pages and images, with a bound on the deviation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Floats, Rows
from cbdsl.robot.meshes.mesh_reader import Mesh, MeshError, read_mesh_file

#: Largest deviation of a simplified mesh, as a share of the longest edge of the box around it.
DEVIATION = 0.045
# Edge of a cell whose diagonal is that deviation, as the same share.
_CELL = DEVIATION / 3**0.5


def read_simplified(file: Path, scale: Sequence[float]) -> Mesh | None:
    """Return a simplified mesh from a file, scaled by ``scale``, or ``None`` if unreadable."""
    try:
        mesh = simplified(read_mesh_file(file, scale))
    except MeshError:
        return None
    # A mirrored mesh has its triangles inside out.
    return mesh if np.prod(scale) > 0 else mesh._replace(triangles=mesh.triangles[:, ::-1])


# Simplification by vertex clustering (Rossignac and Borrel 1993). A grid of cubic cells covers the
# mesh, and the corners in each cell merge into their mean. A triangle is linear in its corners, so
# that none of its points moves farther than a corner: at most a cell's diagonal. Triangles with two
# corners in one cell become an edge or a point. That loses nothing if the edge is part of the
# remaining surface, or if its ends are and the rest is near them. All others, such as those of a
# rod that is thinner than a cell, keep their own corners. The topology is not preserved, which is
# acceptable for display and not for collision geometry.
def simplified(mesh: Mesh) -> Mesh:
    """Return the mesh with near corners merged.

    The distance from any point of either mesh to the other is at most ``DEVIATION`` times the
    longest edge of the box around the mesh.
    """
    lowest = mesh.corners.min(axis=0)
    extent = float((mesh.corners.max(axis=0) - lowest).max())
    places = np.floor((mesh.corners - lowest) / (_CELL * extent or 1.0)).astype(np.intp)
    cell, merged = _clusters(places, mesh.corners)
    shift = float(np.linalg.norm(merged[cell] - mesh.corners, axis=1).max())
    triangles = cell[mesh.triangles]
    a, b, c = triangles.T
    flat = (a == b) | (b == c) | (c == a)
    kept, ends = triangles[~flat], np.stack([triangles.min(axis=1), triangles.max(axis=1)], axis=1)
    longest = 2.0 * (DEVIATION * extent - shift)
    is_near = np.linalg.norm(merged[ends[:, 0]] - merged[ends[:, 1]], axis=1) <= longest
    is_there = np.isin(ends, kept).all(axis=1) & is_near | _have_edge(ends, kept, len(merged))
    lost = mesh.triangles[flat & ~is_there]
    corners = np.vstack([merged, mesh.corners])
    return _used(Mesh(corners, np.vstack([_distinct(kept), lost + len(merged)])))


def _clusters(places: Rows, corners: Floats) -> tuple[Rows, Floats]:
    """Return the cluster of each corner, and the mean of the corners in each cluster."""
    # One number per cell: unique rows take ten times as long.
    numbers = np.ravel_multi_index(tuple(places.T), tuple(places.max(axis=0) + 1))
    _, cell, count = np.unique(numbers, return_inverse=True, return_counts=True)
    cell = cell.reshape(-1)
    sums = [np.bincount(cell, weights=axis) for axis in corners.T]
    return cell, np.stack(sums, axis=1) / count[:, None]


def _have_edge(ends: Rows, triangles: Rows, count: int) -> NDArray[np.bool_]:
    """Return whether each pair of ``count`` corners, smaller first, is an edge of a triangle."""
    sides = np.vstack([triangles[:, (0, 1)], triangles[:, (1, 2)], triangles[:, (2, 0)]])
    has_edge: NDArray[np.bool_] = np.isin(ends @ (count, 1), np.sort(sides, axis=1) @ (count, 1))
    return has_edge


def _distinct(triangles: Rows) -> Rows:
    """Return triangles without duplicates, which have the same corners in any order."""
    if not len(triangles):
        return triangles
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    return triangles[np.sort(first)]


def _used(mesh: Mesh) -> Mesh:
    """Return a mesh without corners of no triangle."""
    used, rows = np.unique(mesh.triangles, return_inverse=True)
    return Mesh(mesh.corners[used], rows.reshape(-1, 3))
