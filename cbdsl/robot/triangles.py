"""Triangles of mesh files: STL, in text or bytes, and OBJ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cbdsl.errors.errors import UsageError

Floats = NDArray[np.float64]

#: Most triangles of a mesh, and its longest and shortest extent, m.
MOST, LONGEST, SHORTEST = 200_000, 2.0, 0.001
# A triangle in an STL of bytes: normal, three corners, and two bytes that nobody uses.
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
_HEAD = 84
# Corners nearer to each other than this share of the longest extent are one.
_SAME = 1e-6


def read_triangles(file: Path, scale: float = 1.0) -> Floats:
    """The corners of a closed mesh's triangles, m, shape (n, 3, 3).

    Args:
        file: the mesh.
        scale: of its unit, m.

    Raises:
        UsageError: there is no such file, it is no mesh, or none of a thing that a hand could hold.
    """
    if not file.is_file():
        raise UsageError(f"{file}: there is no such mesh")
    readers = {".stl": _stl, ".obj": _obj}
    read = readers.get(file.suffix.lower())
    if read is None:
        raise UsageError(f"{file}: not a mesh of a known format; known: {', '.join(readers)}")
    try:
        triangles = scale * read(file.read_bytes())
    except (ValueError, IndexError, UnicodeDecodeError) as error:
        raise UsageError(f"{file}: not a mesh: {error}") from error
    _require_reasonable(file, triangles)
    return triangles


def _require_reasonable(file: Path, triangles: Floats) -> None:
    if not len(triangles) or not np.isfinite(triangles).all():
        raise UsageError(f"{file}: a mesh without triangles, or with numbers that are not finite")
    if len(triangles) > MOST:
        raise UsageError(f"{file}: {len(triangles)} triangles; {MOST} are the most")
    extent = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    if not SHORTEST <= extent <= LONGEST:
        raise UsageError(
            f"{file}: {extent:.3g} m long; things are {1000 * SHORTEST:g} mm to {LONGEST:g} m. "
            "Where its unit is not the metre, its scale (--scale) says how long it is: 0.001 for mm"
        )
    if gaps := _open_edges(triangles, extent):
        raise UsageError(f"{file}: not closed: {gaps} edges do not join two triangles")


def _open_edges(triangles: Floats, extent: float) -> int:
    """Number of edges that are not those of two triangles, one in each direction."""
    corners = np.round(triangles.reshape(-1, 3) / (_SAME * extent)).astype(np.int64)
    _, numbers = np.unique(corners, axis=0, return_inverse=True)
    faces = numbers.reshape(-1, 3)
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    lower, upper = edges.min(axis=1), edges.max(axis=1)
    directions = np.where(edges[:, 0] == lower, 1, -1)
    _, places = np.unique(np.stack([lower, upper], axis=1), axis=0, return_inverse=True)
    return int(np.count_nonzero(np.bincount(places.ravel(), weights=directions)))


def _stl(data: bytes) -> Floats:
    if len(data) >= _HEAD:
        count = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
        if len(data) == _HEAD + count * _RECORD.itemsize:
            records = np.frombuffer(data, _RECORD, count, _HEAD)
            return records["corners"].astype(np.float64)
    lines = [line.split() for line in data.decode("utf-8").splitlines()]
    corners = [list(map(float, words[1:4])) for words in lines if words[:1] == ["vertex"]]
    return np.array(corners).reshape(-1, 3, 3)


def _obj(data: bytes) -> Floats:
    points: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for line in data.decode("utf-8").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(list(map(float, words[1:4])))
        elif words[:1] == ["f"]:
            # Numbers count from 1, or back from the newest point.
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            own = [number - 1 if number > 0 else len(points) + number for number in numbers]
            if min(own) < 0 or max(own) >= len(points):
                raise ValueError(f"'{line}' names a point that is not there")
            faces += [(own[0], own[k], own[k + 1]) for k in range(1, len(own) - 1)]
    return np.array(points).reshape(-1, 3)[np.array(faces, dtype=np.int64).reshape(-1, 3)]
