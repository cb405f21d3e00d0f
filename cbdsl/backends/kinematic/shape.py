"""Shapes of definite size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.solids import BALL, BOX, CYLINDER, WIDTH
from cbdsl.backends.pose import Pose
from cbdsl.documents.stage import Ball, Box, Cylinder

Floats = NDArray[np.float64]
Span = tuple[float, float]


def draw(span: Span, rng: np.random.Generator) -> float:
    """Draw from the uniform distribution over a span."""
    return float(rng.uniform(*span))


@dataclass(frozen=True)
class Shape:
    """A ball, box or cylinder.

    Attributes:
        kind: ``BALL``, ``BOX`` or ``CYLINDER``, which stands along its z.
        halves: half its extents along its own axes, m.
    """

    kind: float
    halves: tuple[float, float, float]

    @classmethod
    def ball(cls, radius: float) -> Shape:
        """A ball of this radius, m."""
        return cls(BALL, (radius, radius, radius))

    @classmethod
    def cylinder(cls, radius: float, height: float) -> Shape:
        """A cylinder of this radius and height, m."""
        return cls(CYLINDER, (radius, radius, height / 2))

    @classmethod
    def draw(cls, form: Ball | Box | Cylinder, rng: np.random.Generator) -> Shape:
        """A shape of this form, of a size drawn from its spans."""
        if isinstance(form, Ball):
            return cls.ball(draw(form.radius, rng))
        if isinstance(form, Box):
            x, y, z = (draw(span, rng) / 2 for span in form.size)
            return cls(BOX, (x, y, z))
        radius = draw(form.radius, rng)
        return cls.cylinder(radius, draw(form.height, rng))

    @property
    def half_height(self) -> float:
        """From its centre to its lowest point while it stands upright, m."""
        return self.halves[2]

    def depth(self, rotation: Floats) -> float:
        """From its centre to its lowest point with these axes, shape (3, 3), m."""
        x, y, z = np.abs(rotation[2]).tolist()
        a, b, c = self.halves
        if self.kind == BALL:
            return a
        if self.kind == CYLINDER:
            return float(a * np.hypot(x, y) + c * z)
        return float(a * x + b * y + c * z)

    def row(self, pose: Pose) -> Floats:
        """As ``solids`` has it, shape (16,)."""
        row = np.empty(WIDTH)
        row[0], row[1:4] = self.kind, self.halves
        row[4:7], row[7:16] = pose.position, pose.rotation.ravel()
        return row
