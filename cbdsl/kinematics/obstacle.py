"""Obstacles that a motion avoids."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats


class Obstacle(NamedTuple):
    """Set of points within ``radius`` of a box: a sphere if the box is a point.

    Attributes:
        name: Name for messages.
        lower: Lower corner of the box, in the unit of the space, shape (n,).
        upper: Upper corner of the box, shape (n,).
        radius: Extent of the obstacle beyond the box, in the same unit.
    """

    name: str
    lower: Floats
    upper: Floats
    radius: float = 0.0

    @classmethod
    def sphere(cls, name: str, centre: Floats, radius: float) -> Obstacle:
        """Return the obstacle of all points within ``radius`` of ``centre``, shape (n,)."""
        return cls(name, centre, centre, radius)

    def grown(self, clearance: float) -> Obstacle:
        """Return the obstacle enlarged by a clearance."""
        return self._replace(radius=self.radius + clearance)

    def around(self, goal: Floats, shaft: float) -> list[Obstacle]:
        """Return the parts of the obstacle that a shaft through it leaves.

        Args:
            goal: Middle of the shaft, shape (n,), n >= 2.
            shaft: Half of its width along the first two axes.

        Returns:
            Up to four boxes of the same name.
        """
        low, high = goal - shaft, goal + shaft
        sides = (  # corners along the first two axes
            (self.lower[:2], (low[0], self.upper[1])),
            ((high[0], self.lower[1]), self.upper[:2]),
            ((low[0], self.lower[1]), (high[0], low[1])),
            ((low[0], high[1]), (high[0], self.upper[1])),
        )
        boxes = []
        for lower, upper in sides:
            first, last = self.lower.copy(), self.upper.copy()
            first[:2] = np.maximum(first[:2], lower)
            last[:2] = np.minimum(last[:2], upper)
            if (first <= last).all():
                boxes.append(self._replace(lower=first, upper=last))
        return boxes

    def gaps(self, coordinates: Floats, axis: int) -> Floats:
        """Return distances of coordinates along one axis from the box, 0 within it."""
        below, above = self.lower[axis] - coordinates, coordinates - self.upper[axis]
        beside: Floats = np.maximum(np.maximum(below, above), 0.0)
        return beside

    def distance(self, point: Floats) -> float:
        """Return the distance from the surface to a point, shape (n,); negative or 0 inside."""
        beside = np.maximum(np.maximum(self.lower - point, point - self.upper), 0.0)
        return float(np.linalg.norm(beside)) - self.radius

    def differs(self, other: Obstacle, tolerance: float) -> bool:
        """Return whether a corner or the radius differs by more than ``tolerance``."""
        return self.name != other.name or not (
            np.abs(self.lower - other.lower).max() <= tolerance
            and np.abs(self.upper - other.upper).max() <= tolerance
            and abs(self.radius - other.radius) <= tolerance
        )
