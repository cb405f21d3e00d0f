"""Obstacles that a motion keeps away from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Obstacle(NamedTuple):
    """All points within ``radius`` of a box: a sphere where the box is a point.

    Attributes:
        name: what messages call it.
        lower: the box's lower corner, in the unit of the space, shape (n,).
        upper: its upper corner, shape (n,).
        radius: how far the obstacle reaches beyond the box, in the same unit.
    """

    name: str
    lower: Floats
    upper: Floats
    radius: float = 0.0

    @classmethod
    def sphere(cls, name: str, centre: Floats, radius: float) -> Obstacle:
        """All points within ``radius`` of ``centre``, shape (n,)."""
        return cls(name, centre, centre, radius)

    def grown(self, clearance: float) -> Obstacle:
        """The obstacle with all that is nearer to it than ``clearance``."""
        return self._replace(radius=self.radius + clearance)

    def around(self, goal: Floats, shaft: float) -> list[Obstacle]:
        """Parts of the obstacle that a shaft through it leaves.

        Args:
            goal: the middle of the shaft, shape (n,), n >= 2.
            shaft: half of its width along the first two axes.

        Returns:
            Boxes of the same name, up to four.
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
        """How far coordinates along one axis lie beside the box, 0 where they lie within."""
        below, above = self.lower[axis] - coordinates, coordinates - self.upper[axis]
        beside: Floats = np.maximum(np.maximum(below, above), 0.0)
        return beside

    def distance(self, point: Floats) -> float:
        """From the surface to a point, shape (n,); negative or 0 inside."""
        beside = np.maximum(np.maximum(self.lower - point, point - self.upper), 0.0)
        return float(np.linalg.norm(beside)) - self.radius

    def differs(self, other: Obstacle, tolerance: float) -> bool:
        """Whether some corner or the radius is off by more than ``tolerance``."""
        return self.name != other.name or not (
            np.abs(self.lower - other.lower).max() <= tolerance
            and np.abs(self.upper - other.upper).max() <= tolerance
            and abs(self.radius - other.radius) <= tolerance
        )
