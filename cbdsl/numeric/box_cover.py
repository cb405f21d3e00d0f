"""Box covers: the interior of a closed surface as a few boxes that do not overlap."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.numeric.compiled import compiled_once

# Number of cells along the longest extent.
_CELLS = 32
# Offset of rays, in cells, so that they do not meet edges.
_ASIDE = np.array((1.3e-4, 2.9e-4))


class Cover(NamedTuple):
    """Boxes inside a surface.

    Attributes:
        boxes: Centre, then edges along x, y and z, m, shape (k, 2, 3); the largest first.
        share: Share of the cells inside the surface that the boxes cover.
    """

    boxes: Floats
    share: float


def cover(triangles: Floats, most: int) -> Cover:
    """Return axis-aligned boxes that fill a closed surface, each the largest possible one.

    Args:
        triangles: Corners of the triangles, m, shape (n, 3, 3).
        most: Largest number of boxes.
    """
    low: Floats = triangles.reshape(-1, 3).min(axis=0)
    extent: Floats = triangles.reshape(-1, 3).max(axis=0) - low
    counts: Integers = np.maximum(np.round(_CELLS * extent / float(extent.max())), 1).astype(
        np.int64
    )
    size = extent / counts
    inside = _inside((triangles - low) / size, counts)
    left, boxes = inside.copy(), []
    for _ in range(most):
        box: Integers = np.array(_largest(left), dtype=np.int64)
        if not box[3:].all():
            break
        first: Integers = box[:3]
        edges: Integers = box[3:]
        left[tuple(slice(a, a + n) for a, n in zip(first, edges, strict=True))] = False
        boxes.append((low + (first + edges / 2) * size, edges * size))
    uncovered, cells = int(left.sum()), int(inside.sum())
    return Cover(np.array(boxes).reshape(-1, 2, 3), 1 - uncovered / max(1, cells))


def _inside(triangles: Floats, counts: Integers) -> Booleans:
    """Return the cells with centres inside, by the parity of crossings of a ray along z."""
    met = np.zeros((*counts, 1), np.int64).squeeze(3)
    for triangle in triangles:
        first = np.maximum(np.floor(triangle[:, :2].min(axis=0) - 0.5).astype(int), 0)
        last = np.minimum(np.ceil(triangle[:, :2].max(axis=0)).astype(int) + 1, counts[:2])
        if (last <= first).any():
            continue
        columns, rows = np.meshgrid(*map(np.arange, first, last), indexing="ij")
        places = np.stack([columns, rows], axis=-1) + 0.5 + _ASIDE
        a, b, c = triangle
        plane = np.stack([b - a, c - a])[:, :2].T
        if abs(np.linalg.det(plane)) < 1e-12:
            continue
        shares = (places - a[:2]) @ np.linalg.inv(plane).T
        hit = (shares >= 0).all(axis=-1) & (shares.sum(axis=-1) <= 1)
        heights = a[2] + shares @ np.array([b[2] - a[2], c[2] - a[2]])
        for column, row, height in zip(columns[hit], rows[hit], heights[hit], strict=True):
            met[column, row, max(0, int(np.ceil(height - 0.5))) :] += 1
    odd: Booleans = met % 2 == 1
    return odd


@compiled_once
def _largest(free: Booleans) -> tuple[int, int, int, int, int, int]:
    """Return the largest box of free cells: its first cell, and its cells along x, y and z."""
    columns, rows, layers = free.shape
    best, widest = 0, (0, 0, 0, 0, 0, 0)
    for bottom in range(layers):
        flat = np.ones((columns, rows), np.bool_)
        for top in range(bottom, layers):
            depth = np.zeros(rows, np.int64)
            for column in range(columns):
                for row in range(rows):
                    flat[column, row] &= free[column, row, top]
                    depth[row] = depth[row] + 1 if flat[column, row] else 0
                # Find the largest rectangle that ends in this column.
                for first in range(rows):
                    width = depth[first]
                    for last in range(first, rows):
                        width = min(width, depth[last])
                        if width == 0:
                            break
                        volume = width * (last - first + 1) * (top - bottom + 1)
                        if volume > best:
                            best = volume
                            widest = (
                                column - width + 1, first, bottom,
                                width, last - first + 1, top - bottom + 1,
                            )  # fmt: skip
    return widest
