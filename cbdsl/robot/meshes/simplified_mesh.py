"""Simplification of meshes for web pages."""

from __future__ import annotations

import numpy as np

from cbdsl.robot.meshes.mesh_reader import Mesh

# Sufficient to recognise a link's shape; a robot of 30 links then takes half a megabyte.
_MOST_TRIANGLES = 1500
_FINEST = 64


# Simplification by vertex clustering (Rossignac and Borrel 1993). A grid of cubic cells covers the
# mesh, and the corners in each cell merge into their mean. Triangles with two corners in the same
# cell vanish. The topology is not preserved: thin walls collapse and small gaps close. This is
# acceptable for display, but not for collision geometry. The grid is coarsened by a quarter at a
# time. The loop ends at the latest with one cell along the longest edge: at most eight clusters
# form fewer triangles than the bound.
def simplified(mesh: Mesh) -> Mesh:
    """Return the mesh with near corners merged, until it is small enough."""
    cells = _FINEST
    small = _merged(mesh, cells)
    while len(small.triangles) > _MOST_TRIANGLES:
        cells = cells * 3 // 4
        small = _merged(mesh, cells)
    return small


def _merged(mesh: Mesh, cells: int) -> Mesh:
    """Merge the corners in each cell into their mean, ``cells`` along the longest edge."""
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
