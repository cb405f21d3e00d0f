"""Corners and triangles of mesh files, in every format that Pinocchio reads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats, Rows

#: Largest size of a file for the reader, bytes.
MOST_BYTES = 100_000_000


class MeshError(ValueError):
    """Unreadable mesh file; the message says why."""


class Mesh(NamedTuple):
    """Rows of a mesh.

    Attributes:
        corners: Positions of the corners, m, shape (corners, 3).
        triangles: Indices of the triangles' corners, shape (triangles, 3).
    """

    corners: Floats
    triangles: Rows


def read_mesh_file(file: Path, scale: Sequence[float]) -> Mesh:
    """Return the mesh in a file, its corners times ``scale``.

    Raises:
        MeshError: If the file is not a mesh, or the reader is not installed.
    """
    try:
        # installed with Pinocchio
        import coal
    except ImportError as error:
        raise MeshError(f"{file}: the reader of meshes is not installed: {error}") from error
    try:
        # The native reader loads the whole file, so its size has to be checked before.
        size = file.stat().st_size
    except OSError as error:
        raise MeshError(f"{file}: {error.strerror}") from error
    if size > MOST_BYTES or not file.is_file():
        raise MeshError(f"{file}: not a file of at most {MOST_BYTES} bytes")
    try:
        loaded: Any = coal.MeshLoader().load(str(file), np.array(scale, dtype=float))
        corners = np.array(loaded.vertices(), dtype=np.float64).reshape(-1, 3)
        rows = [loaded.tri_indices(index) for index in range(loaded.num_tris)]
    except (RuntimeError, ValueError) as error:
        # The position in the reader's source is of no use here.
        reason = " ".join(str(error).partition("message: ")[2].split()) or str(error)
        raise MeshError(f"{file}: {reason}") from error
    triangles = np.array([[row[0], row[1], row[2]] for row in rows], dtype=np.intp).reshape(-1, 3)
    if not len(triangles):
        raise MeshError(f"{file}: it has no triangles")
    return Mesh(corners, triangles)
