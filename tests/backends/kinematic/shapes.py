"""Shapes that tests measure by their definitions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.shape import SolidShape
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats

SHAPES = {
    "ball": SolidShape.ball(0.07),
    "box": SolidShape("box", (0.05, 0.08, 0.03)),
    "cylinder": SolidShape.cylinder(0.06, 0.14),
}


def turned(rng: np.random.Generator) -> Floats:
    axis = rng.standard_normal(3)
    return Pose.turned(axis / np.linalg.norm(axis), rng.uniform(-3, 3)).rotation


def inside(shape: SolidShape, points: Floats) -> NDArray[np.bool_]:
    """Return a mask of points inside the shape, given in its frame, shape (n, 3)."""
    a, _, c = shape.halves
    if shape.kind == "ball":
        return np.linalg.norm(points, axis=1) <= a
    if shape.kind == "cylinder":
        return (np.hypot(points[:, 0], points[:, 1]) <= a) & (np.abs(points[:, 2]) <= c)
    return (np.abs(points) <= shape.halves).all(axis=1)
