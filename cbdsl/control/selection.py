"""Rows that read single joints, such as those of a configuration."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.signal import Floats

Booleans = NDArray[np.bool_]


class Selection(NamedTuple):
    """Rows with at most one number each, each in a column of its own.

    Attributes:
        joints: whether a row reads the joint, shape (n,).
        scales: the rows' numbers, shape (k,).
    """

    joints: Booleans
    scales: Floats

    @classmethod
    def of(cls, rows: Floats) -> Selection | None:
        """What rows (k, n) select, or ``None`` if they are no selection."""
        numbers = np.count_nonzero(rows)
        if numbers > len(rows):
            return None
        # Two numbers in a row, or in a column, leave another one empty.
        scales = rows.dot(_ones(rows.shape[1]))
        if np.count_nonzero(scales) != numbers:
            return None
        joints = _ones(len(rows)).dot(rows) != 0.0
        return cls(joints, scales) if np.count_nonzero(joints) == numbers else None


@cache
def _ones(count: int) -> Floats:
    return np.ones(count)
