"""Triangles of mesh files: STL, in text or binary, and OBJ."""

from __future__ import annotations

import io
from array import array
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.numeric.arrays import Floats
from cbdsl.storage.contents import contents

#: Largest number of triangles of a mesh, and its longest and shortest extent, m.
MOST, LONGEST, SHORTEST = 200_000, 2.0, 0.001
#: Largest size of its file, bytes: twice that of a binary STL with the most triangles.
MOST_BYTES = 20_000_000
# Triangle in a binary STL: normal, three corners, and two unused bytes.
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
_HEAD = 84
# Distance below which corners coincide, as a share of the longest extent.
_SAME = 1e-6


def read_triangles(file: Path, scale: float = 1.0) -> Floats:
    """Return the corners of a closed mesh's triangles, m, shape (n, 3, 3).

    Args:
        file: Path of the mesh.
        scale: Length of its unit, m.

    Raises:
        UsageError: If there is no such file, or it is not a mesh of an object of graspable size.
    """
    readers = {".stl": _stl, ".obj": _obj}
    read = readers.get(file.suffix.lower())
    if read is None:
        raise UsageError(f"{file}: not a mesh of a known format; known: {', '.join(readers)}")
    try:
        triangles = scale * read(contents(file, MOST_BYTES))
    except FileNotFoundError as error:
        raise UsageError(f"{file}: there is no such mesh") from error
    except OSError as error:
        raise UsageError(f"{file}: {reason(error)}") from error
    except (ValueError, IndexError, OverflowError) as error:
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


# A mesh is closed if its triangles pass each edge equally often in both directions. A passage from
# the lower to the higher corner counts +1 and its reverse -1, so that the sum over each edge
# vanishes. This also detects neighbours of opposite orientation. STL repeats each corner in every
# triangle, possibly rounded differently, so corners in the same cell of a fine grid coincide. The
# model fails for corners on both sides of a cell's boundary: they stay distinct, and a gap is
# reported.
def _open_edges(triangles: Floats, extent: float) -> int:
    """Return the number of edges without two triangles, one in each direction."""
    rows = triangles.reshape(-1, 3)
    # A cell of at most 20 bits along each axis, packed into one number, because rows are slow to
    # compare.
    cells = np.round((rows - rows.min(axis=0)) / (_SAME * extent)).astype(np.int64)
    _, numbers = np.unique(
        (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2], return_inverse=True
    )
    faces = numbers.reshape(-1, 3)
    # Triangles that the grid collapses to a line have no area and are left out.
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    lower, upper = edges.min(axis=1), edges.max(axis=1)
    directions = np.where(edges[:, 0] == lower, 1, -1)
    _, places = np.unique(lower * len(rows) + upper, return_inverse=True)
    return int(np.count_nonzero(np.bincount(places.ravel(), weights=directions)))


def _stl(data: bytes) -> Floats:
    # The length distinguishes the formats, because a binary STL may begin with "solid", too.
    if len(data) >= _HEAD:
        count = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
        if len(data) == _HEAD + count * _RECORD.itemsize:
            records = np.frombuffer(data, _RECORD, count, _HEAD)
            return records["corners"].astype(np.float64)
    numbers = array("d")
    for line in _lines(data):
        words = line.split(None, 5)
        if words[:1] == ["vertex"]:
            x, y, z = words[1:4]
            numbers.extend((float(x), float(y), float(z)))
            _require_few(len(numbers) // 9)
    return np.array(numbers).reshape(-1, 3, 3)


def _obj(data: bytes) -> Floats:
    points, faces, count = array("d"), array("q"), 0
    for line in _lines(data):
        key, _, rest = line.partition(" ")
        if key == "v":
            x, y, z = rest.split(None, 3)[:3]
            points.extend((float(x), float(y), float(z)))
            count += 1
            _require_few(count // 3)
        elif key == "f":
            own = _face(rest, count)
            # A polygon becomes a fan of triangles around its first corner, which is exact for
            # convex polygons.
            for k in range(1, len(own) - 1):
                faces.extend((own[0], own[k], own[k + 1]))
            _require_few(len(faces) // 3)
    corners = np.array(points).reshape(-1, 3)
    return corners[np.array(faces, dtype=np.int64).reshape(-1, 3)]


def _face(text: str, points: int) -> list[int]:
    """Return the indices of a face's points; they count from 1, or back from the newest point."""
    words = text.split(None, MOST + 2)
    _require_few(len(words) - 2)
    # In "7/2/5", texture and normal follow the index of the point.
    numbers = [int(word.partition("/")[0]) for word in words]
    own = [number - 1 if number > 0 else points + number for number in numbers]
    if own and (min(own) < 0 or max(own) >= points):
        raise ValueError(f"a face of {len(own)} points names a point that is not there")
    return own


def _lines(data: bytes) -> Iterator[str]:
    """Yield the lines of a text, whose words are separated by single spaces, one at a time."""
    for line in io.TextIOWrapper(io.BytesIO(data), "utf-8"):
        yield line.strip().replace("\t", " ")


def _require_few(triangles: int) -> None:
    """Refuse a mesh before reading more of it.

    Raises:
        ValueError: If it has too many triangles.
    """
    if triangles > MOST:
        raise ValueError(f"more than {MOST} triangles")
