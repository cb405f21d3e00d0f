"""Convex bodies: balls, boxes, cylinders and hulls, and the distance between two of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cbdsl.numeric.arrays import Floats

_STEPS = 64
# Squared distances, and gains of a step in them, that count as zero, m^2.
_CLOSE = 1e-12
# Share of a point in the nearest one that counts as zero.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Convex:
    """Ball, box, cylinder or hull in the world; a cylinder lies along its z axis.

    Attributes:
        kind: Kind of body.
        halves: Half extents along its own axes, m.
        position: Position of its centre, m, shape (3,).
        rotation: Rotation matrix with its axes as columns, shape (3, 3).
        corners: Corners of a hull, in its own axes around its centre, m, shape (k, 3).
    """

    kind: Literal["ball", "box", "cylinder", "hull"]
    halves: tuple[float, float, float]
    position: Floats
    rotation: Floats
    corners: Floats | None = None

    @property
    def radius(self) -> float:
        """Radius of the ball around its centre that contains it, m."""
        return self.halves[0] if self.kind == "ball" else math.hypot(*self._half_diagonal)

    @property
    def _half_diagonal(self) -> tuple[float, ...]:
        a, b, c = self.halves
        return (a, c) if self.kind == "cylinder" else (a, b, c)

    def support(self, direction: Floats) -> Floats:
        """Return the point of the body that is farthest in a direction, m, shape (3,)."""
        along = direction @ self.rotation
        if self.corners is not None:
            farthest: Floats = self.corners[int(np.argmax(self.corners @ along))]
            return np.asarray(self.position + self.rotation @ farthest, dtype=np.float64)
        u, v, w = (float(part) for part in along)
        a, b, c = self.halves
        if self.kind == "box":
            own = (math.copysign(a, u), math.copysign(b, v), math.copysign(c, w))
        elif self.kind == "cylinder":
            across = math.hypot(u, v) or 1.0
            own = (a * u / across, a * v / across, math.copysign(c, w))
        else:
            size = math.hypot(u, v, w) or 1.0
            own = (a * u / size, a * v / size, a * w / size)
        point: Floats = self.position + self.rotation @ np.array(own)
        return point

    def shrunk(self, margin: float) -> Convex:
        """Return the body shrunk by ``margin``, m, but at most half way to its middle."""
        a, b, c = (max(half - margin, half / 2) for half in self.halves)
        if self.corners is None:
            return replace(self, halves=(a, b, c))
        shares = np.array((a, b, c)) / np.array(self.halves)
        # The middle of the box around a hull may be on its surface.
        middle = self.corners.mean(axis=0)
        return replace(self, halves=(a, b, c), corners=middle + shares * (self.corners - middle))


def gap(one: Convex, other: Convex) -> float:
    """Return the distance between two bodies, m; 0 if they touch or overlap.

    The distance is the least norm of a point in the bodies' difference, found by Wolfe's algorithm
    (Mathematical Programming 11, 1976). Up to four points of the difference span a hull. The hull's
    nearest point to the origin determines the next point of the difference.
    """
    nearest = one.position - other.position
    points, shares = np.empty((0, 3)), np.empty(0)
    for _ in range(_STEPS):
        point = one.support(-nearest) - other.support(nearest)
        square = float(nearest @ nearest)
        if len(points) and square - float(nearest @ point) <= _CLOSE:
            break
        points, shares = np.vstack((points, point)), np.append(shares, 0.0 if len(points) else 1.0)
        points, shares = _nearest_shares(points, shares)
        nearest = shares @ points
        if float(nearest @ nearest) <= _CLOSE:
            return 0.0
    return math.sqrt(float(nearest @ nearest))


def _nearest_shares(points: Floats, shares: Floats) -> tuple[Floats, Floats]:
    """Return the points that span the hull's nearest point to the origin, and their shares."""
    while True:
        wanted = _affine_shares(points)
        outside = wanted <= _ROUNDING
        if not outside.any():
            return points, wanted
        # Move from the current shares towards the desired ones until the first becomes zero.
        steps = shares[outside] / np.maximum(shares[outside] - wanted[outside], _ROUNDING)
        shares = shares + min(1.0, float(steps.min())) * (wanted - shares)
        kept = shares > _ROUNDING
        if kept.all():  # by rounding only
            kept[np.argmin(np.where(outside, shares, np.inf))] = False
        points, shares = points[kept], shares[kept] / shares[kept].sum()


def _affine_shares(points: Floats) -> Floats:
    """Return the shares, of sum 1, of the affine hull's point that is nearest to the origin."""
    count = len(points)
    system = np.ones((count + 1, count + 1))
    system[0, 0] = 0.0
    system[1:, 1:] = points @ points.T
    right = np.zeros(count + 1)
    right[0] = 1.0
    solution = np.linalg.lstsq(system, right, rcond=None)[0]
    return np.asarray(solution[1:], dtype=np.float64)
