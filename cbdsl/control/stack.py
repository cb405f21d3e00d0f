"""Levels of a composition, tick by tick: controllers write them, the law reads them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbdsl.control.half_tick import extrapolate_half_tick
from cbdsl.control.level import Level, LevelArrays
from cbdsl.control.signal import SignalError
from cbdsl.numeric.arrays import Floats

#: Number of ticks that are kept.
TICKS = 3


class Stack:
    """Levels, highest priority first, with k rows in all, of n joints.

    Attributes:
        names: Names of the controllers.
        rows: Task coordinates per joint in three ticks, shape (3, k, n).
        clock: Index of this tick among the three, shape (1,); the preceding tick is one less,
            modulo 3.
        wanted: Requested displacement of the task coordinates in this tick, shape (k,).
        starts: Index of the first row of each level, shape (levels,).
        ends: Index after the last row of each level, shape (levels,).
        ages: Number of consecutive ticks in which each level has acted, up to 3; 0 if it does not
            act, shape (levels,).
        arrays: All of these except the names, with the levels' second order.

    Args:
        levels: Names of the controllers with their numbers of task coordinates.
        joints: Number n of joints.
    """

    def __init__(self, levels: Sequence[tuple[str, int]], joints: int) -> None:
        self.names = tuple(name for name, _ in levels)
        sizes = np.array([size for _, size in levels], dtype=np.int64)
        self.ends = np.cumsum(sizes)
        self.starts = self.ends - sizes
        size = int(sizes.sum())
        self.rows, self.wanted = np.zeros((TICKS, size, joints)), np.zeros(size)
        self.ages = np.zeros(len(levels), dtype=np.int64)
        self.clock = np.zeros(1, dtype=np.int64)
        self.arrays = LevelArrays(
            self.clock, self.rows, self.ages, self.wanted, self.ends, np.ones(len(levels)),
            np.zeros(len(levels)), np.zeros(len(levels), dtype=np.bool_),
            np.zeros((size, joints, joints)), np.zeros(len(levels), dtype=np.int64),
            np.zeros(1, dtype=np.bool_), np.zeros(size), np.zeros(size, dtype=np.bool_),
        )  # fmt: skip

    @classmethod
    def of(cls, levels: Sequence[Level], joints: int) -> Stack:
        """Return a stack of levels that act for the first time.

        Raises:
            SignalError: If a level's shape does not fit.
        """
        stack = cls([(level.name, len(level.velocity)) for level in levels], joints)
        for place, level in enumerate(levels):
            stack.put(place, level)
        return stack

    def put(self, place: int, level: Level) -> None:
        """Add a level to this tick.

        Raises:
            SignalError: If its shape does not fit.
        """
        rows = self.rows[self.newest, self.starts[place] : self.ends[place]]
        if level.jacobian.shape != rows.shape:
            raise SignalError(
                f"{level.name} wants {len(level.velocity)} coordinates of {self.rows.shape[2]} "
                f"joints, but its Jacobian has shape {level.jacobian.shape}"
            )
        rows[:] = level.jacobian
        self.wanted[self.starts[place] : self.ends[place]] = level.velocity
        self.arrays.fractions[place] = level.fraction
        self.arrays.errors[place] = np.linalg.norm(level.velocity) / level.fraction
        self.arrays.curved[place] = level.hessian is not None
        if level.hessian is not None:
            self.arrays.hessians[self.starts[place] : self.ends[place]] = level.hessian
        self.ages[place] = min(self.ages[place] + 1, TICKS)

    @property
    def newest(self) -> int:
        """Index of this tick among the three."""
        return int(self.clock[0])

    def forget(self) -> None:
        """Forget the preceding ticks, because other controllers have acted since."""
        self.ages[:], self.arrays.withheld[:] = 0, 0

    def extrapolated(self) -> tuple[Level, ...]:
        """Return the levels that act, with their Jacobians half a tick ahead."""
        rows = extrapolate_half_tick(self.rows, self.newest, self.ages, self.ends)
        rows[self.arrays.idle] = 0.0
        names = [name for name, age in zip(self.names, self.ages, strict=True) if age]
        parts = zip(names, self.split(rows), self.split(self.requested), strict=True)
        return tuple(Level(name, jacobian, velocity) for name, jacobian, velocity in parts)

    @property
    def acting_rows(self) -> Floats:
        """Rows of this tick, shape (k, n); 0 for bounds that no level reaches."""
        rows: Floats = np.where(self.arrays.idle[:, None], 0.0, self.rows[self.newest])
        return rows

    @property
    def requested(self) -> Floats:
        """Requested displacement of these rows, shape (k,)."""
        requested: Floats = np.where(self.arrays.idle, 0.0, self.wanted)
        return requested

    def split(self, values: Floats) -> list[Floats]:
        """Return the values (k, ...) of each level that acts."""
        spans = zip(self.starts, self.ends, self.ages, strict=True)
        return [values[start:end] for start, end, age in spans if age]
