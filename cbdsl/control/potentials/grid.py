"""Regular grid over a box, with its free and connected vertices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Booleans, Floats

Owners = NDArray[np.int32]
Vertex = tuple[int, ...]

FREE, BORDER = -1, -2


@dataclass(frozen=True)
class Grid:
    """Vertices ``lower + spacing * index``, each with the cell of points nearest to it.

    Attributes:
        lower: Position of the first vertex, shape (n,).
        spacing: Distance between neighbours along every axis, in the same unit.
        shape: Number of vertices along each axis; the first and the last are the border.
    """

    lower: Floats
    spacing: float
    shape: tuple[int, ...]

    @classmethod
    def between(cls, lower: Floats, upper: Floats, spacing: float) -> Grid:
        """Return the largest grid from ``lower``, shape (n,), that stays within ``upper``.

        Raises:
            ValueError: If there are not 1 to 3 dimensions, or no vertex is inside the border.
        """
        if not 1 <= len(lower) == len(upper) <= 3:
            raise ValueError("a grid has one, two or three dimensions")
        if not (np.isfinite(lower).all() and np.isfinite(upper).all() and spacing > 0):
            raise ValueError("a grid needs finite bounds and a positive spacing")
        cells = np.floor((upper - lower) / spacing + 1e-9).astype(int)
        if cells.min() < 2:
            raise ValueError("a grid needs at least two cells along each axis")
        return cls(lower, spacing, tuple(int(n) + 1 for n in cells))

    def position(self, vertex: Vertex) -> Floats:
        """Return the position of a vertex, shape (n,)."""
        return self.lower + self.spacing * np.array(vertex)

    def nearest(self, point: Floats) -> Vertex | None:
        """Return the vertex whose cell contains a point, shape (n,), or ``None`` outside."""
        index = np.rint((point - self.lower) / self.spacing)
        if (index < 0).any() or (index >= self.shape).any():
            return None
        return tuple(int(i) for i in index)

    def holds(self, marked: Booleans, points: Floats) -> bool:
        """Return whether the cells around all of the points, shape (k, n), are marked."""
        index = np.rint((points - self.lower) / self.spacing).astype(int)
        if (index < 0).any() or (index >= self.shape).any():
            return False
        return bool(marked[tuple(index.T)].all())

    def owners(self, obstacles: Sequence[Obstacle]) -> Owners:
        """Return the blocker of each vertex: the first obstacle that its cell touches.

        Returns:
            Index of an obstacle, ``BORDER``, or ``FREE``, with the grid's shape.
        """
        owners = np.full(self.shape, FREE, np.int32)
        for number, obstacle in reversed(list(enumerate(obstacles))):
            self._occupy(owners, number, obstacle)
        for axis in range(owners.ndim):
            np.moveaxis(owners, axis, 0)[[0, -1]] = BORDER
        return owners

    def _occupy(self, owners: Owners, number: int, obstacle: Obstacle) -> None:
        squares, region = [], []
        for axis, count in enumerate(self.shape):
            coordinates = self.lower[axis] + self.spacing * np.arange(count)
            gaps = np.maximum(obstacle.gaps(coordinates, axis) - 0.5 * self.spacing, 0.0)
            near = np.flatnonzero(gaps <= obstacle.radius)
            if not len(near):
                return
            squares.append(gaps[near] ** 2)
            region.append(slice(near[0], near[-1] + 1))
        distances = sum(np.ix_(*squares), start=np.zeros(1))
        owners[tuple(region)][distances <= obstacle.radius**2] = number

    def connected(self, free: Booleans, start: Vertex) -> Booleans:
        """Return the free vertices that are connected to a vertex through neighbours.

        The border must not be free.
        """
        left, joined = free.ravel().copy(), np.zeros(free.size, bool)
        last = np.empty(free.size, np.intp)
        front = np.array([np.ravel_multi_index(start, self.shape)])
        left[front] = False
        steps = np.array([step for stride in self.strides() for step in (-stride, stride)])
        while len(front):
            joined[front] = True
            near = (front[:, None] + steps).ravel()
            near = near[left[near]]
            left[near] = False
            # Remove duplicates without sorting: keep the copy that was written last.
            order = np.arange(len(near))
            last[near] = order
            front = near[last[near] == order]
        return joined.reshape(self.shape)

    def strides(self) -> Iterator[int]:
        """Yield the distance of neighbours along each axis in the flattened grid."""
        for axis in range(len(self.shape)):
            yield int(np.prod(self.shape[axis + 1 :], dtype=int))
