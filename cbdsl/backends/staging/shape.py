"""Shapes of definite size."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.span import draw
from cbdsl.documents.stage import BallForm, BoxForm, CylinderForm, Pattern, Spot

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SolidShape:
    """A ball, box or cylinder.

    Attributes:
        kind: which of them; a cylinder stands along its z.
        halves: half its extents along its own axes, m.
        pattern: what is printed on it, if it is a box.
        spot: what is painted on it, if it is a ball or a box.
    """

    kind: Literal["ball", "box", "cylinder"]
    halves: tuple[float, float, float]
    pattern: Pattern | None = None
    spot: Spot | None = None

    @classmethod
    def ball(cls, radius: float, spot: Spot | None = None) -> SolidShape:
        """A ball of this radius, m."""
        return cls("ball", (radius, radius, radius), spot=spot)

    @classmethod
    def cylinder(cls, radius: float, height: float) -> SolidShape:
        """A cylinder of this radius and height, m."""
        return cls("cylinder", (radius, radius, height / 2))

    @classmethod
    def draw(cls, form: BallForm | BoxForm | CylinderForm, rng: np.random.Generator) -> SolidShape:
        """A shape of this form, of a size drawn from its spans."""
        if isinstance(form, BallForm):
            return cls.ball(draw(form.radius, rng), form.spot)
        if isinstance(form, BoxForm):
            x, y, z = (draw(span, rng) / 2 for span in form.size)
            return cls("box", (x, y, z), form.pattern, form.spot)
        radius = draw(form.radius, rng)
        return cls.cylinder(radius, draw(form.height, rng))

    @property
    def half_height(self) -> float:
        """From its centre to its lowest point while it stands upright, m."""
        return self.halves[2]

    def spot_height(self) -> float:
        """From its centre along the spot's axis to the plane of the spot's edge, m."""
        if self.spot is None:
            raise ValueError("there is no spot")
        if self.kind == "ball":
            return math.sqrt(self.halves[0] ** 2 - self.spot.radius**2)
        return self.halves["xy".index(self.spot.face[1])]

    def depth(self, rotation: Floats) -> float:
        """From its centre to its lowest point with these axes, shape (3, 3), m."""
        a, b, c = self.halves
        if self.kind == "ball":
            return a
        x, y, z = np.abs(rotation[2]).tolist()
        if self.kind == "cylinder":
            return float(a * np.hypot(x, y) + c * z)
        return float(a * x + b * y + c * z)
