"""Connected components of the visible cells of a camera."""

from __future__ import annotations

import numpy as np

from cbdsl.numeric.arrays import Booleans, Integers
from cbdsl.numeric.compiled import compiled


@compiled
def keep_largest(seen: Booleans, size: int) -> None:
    """Keep only the largest component; cells connect by sides or corners.

    Args:
        seen: Visible cells, of which the first ``size`` in each direction count, shape (n, n).
        size: Number of cells in each direction, at most n.
    """
    # The queue cannot overflow, because a cell gets its label when it is queued, and so is queued
    # once.
    labels, queue = np.zeros((size, size), np.int64), np.empty((size * size, 2), np.int64)
    largest, most, count = 0, 0, 0
    for column in range(size):
        for row in range(size):
            if seen[column, row] and labels[column, row] == 0:
                count += 1
                area = _flood(seen, size, column, row, count, labels, queue)
                if area > most:
                    largest, most = count, area
    # Most silhouettes are connected, and need no second pass.
    if count > 1:
        for column in range(size):
            for row in range(size):
                seen[column, row] = labels[column, row] == largest


@compiled
def _flood(
    seen: Booleans, size: int, column: int, row: int, label: int, labels: Integers, queue: Integers
) -> int:
    """Label all cells of the component of one cell; return their number."""
    labels[column, row] = label
    queue[0, 0], queue[0, 1] = column, row
    first, end = 0, 1
    while first < end:
        here, there = queue[first, 0], queue[first, 1]
        first += 1
        for i in range(max(here - 1, 0), min(here + 2, size)):
            for k in range(max(there - 1, 0), min(there + 2, size)):
                if seen[i, k] and labels[i, k] == 0:
                    labels[i, k] = label
                    queue[end, 0], queue[end, 1] = i, k
                    end += 1
    return end
