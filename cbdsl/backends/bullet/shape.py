"""The shapes of things, with sizes drawn, as the simulator wants them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet as p

from cbdsl.backends.bullet.printed_box import create_printed_box
from cbdsl.documents.stage import Ball, Box, Cylinder, Pattern

Span = tuple[float, float]


def draw(span: Span, rng: np.random.Generator) -> float:
    """Draw from the uniform distribution over a span."""
    return float(rng.uniform(*span))


@dataclass(frozen=True)
class Shape:
    """A shape of definite size.

    Attributes:
        kind: the simulator's number for it.
        collision: its size, by the names that collision shapes use.
        visual: its size, by the names that visual shapes use.
        half_height: from its centre to its lowest point while it stands upright, m.
        pattern: what is printed on it, if it is a box.
    """

    kind: int
    collision: Mapping[str, Any]
    visual: Mapping[str, Any]
    half_height: float
    pattern: Pattern | None = None

    @classmethod
    def draw(cls, form: Ball | Box | Cylinder, rng: np.random.Generator) -> Shape:
        """A shape of this form, of a size drawn from its spans."""
        if isinstance(form, Ball):
            radius = draw(form.radius, rng)
            size: dict[str, Any] = {"radius": radius}
            return cls(p.GEOM_SPHERE, size, size, radius)
        if isinstance(form, Box):
            halves = [draw(span, rng) / 2 for span in form.size]
            size = {"halfExtents": halves}
            return cls(p.GEOM_BOX, size, size, halves[2], form.pattern)
        radius, height = draw(form.radius, rng), draw(form.height, rng)
        return cls(
            p.GEOM_CYLINDER,
            {"radius": radius, "height": height},
            {"radius": radius, "length": height},
            height / 2,
        )

    def create(
        self,
        client: int,
        mass: float,
        color: Sequence[float],
        position: Sequence[float],
        quaternion: Sequence[float],
    ) -> int:
        """Put a body of this shape into the world; without mass it does not move."""
        if self.pattern is not None:
            halves = self.collision["halfExtents"]
            return create_printed_box(
                client, halves, self.pattern, mass, color, position, quaternion
            )
        return int(
            p.createMultiBody(
                mass,
                p.createCollisionShape(self.kind, physicsClientId=client, **self.collision),
                p.createVisualShape(
                    self.kind, rgbaColor=[*color, 1], physicsClientId=client, **self.visual
                ),
                list(position),
                list(quaternion),
                physicsClientId=client,
            )
        )
