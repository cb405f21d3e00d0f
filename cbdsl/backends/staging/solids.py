"""Balls, boxes and cylinders as rows of one array.

A row holds the shape's number, its half extents along its own axes, m, its position, m, and its
rotation by rows. The columns of the rotation are the axes. All are in the world frame. Cylinders
stand along their z.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbdsl.backends.staging.shape import SolidShape
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats, Rows
from cbdsl.numeric.compiled import compiled

BALL, BOX, CYLINDER = 0.0, 1.0, 2.0
_NUMBERS = {"ball": BALL, "box": BOX, "cylinder": CYLINDER}
WIDTH = 16
HALVES, POSITION, ROTATION = slice(1, 4), slice(4, 7), slice(7, 16)


def solid_row(shape: SolidShape, pose: Pose) -> Floats:
    """Return the row of a shape at a pose, shape (16,)."""
    solid = np.empty(WIDTH)
    solid[0], solid[HALVES] = _NUMBERS[shape.kind], shape.halves
    solid[POSITION], solid[ROTATION] = pose.position, pose.rotation.ravel()
    return solid


class Walls:
    """Solids that some objects consist of, in one array for all of them.

    Args:
        shapes: Shapes of the objects.

    Attributes:
        owners: Index of the object that each solid belongs to, shape (m,).
    """

    def __init__(self, shapes: Sequence[SolidShape]) -> None:
        self._are_objects = not any(shape.walls for shape in shapes)
        if self._are_objects:
            self.owners: Rows = np.arange(len(shapes))
            return
        walls = [(index, wall) for index, shape in enumerate(shapes) for wall in shape.solids]
        self.owners = np.array([index for index, _ in walls], np.intp)
        rows = [solid_row(wall.shape, Pose.at(wall.origin)) for _, wall in walls]
        self._own = np.array(rows).reshape(len(walls), WIDTH)

    def at(self, solids: Floats) -> Floats:
        """Return the solids in the world, shape (m, 16).

        Args:
            solids: Rows of the objects, shape (k, 16), which are returned if none is hollow.
        """
        if self._are_objects:
            return solids
        rows = self._own.copy()
        turned = solids[self.owners, ROTATION].reshape(-1, 3, 3)
        shifts = np.einsum("mij,mj->mi", turned, self._own[:, POSITION])
        rows[:, POSITION] = solids[self.owners, POSITION] + shifts
        own = self._own[:, ROTATION].reshape(-1, 3, 3)
        rows[:, ROTATION] = (turned @ own).reshape(-1, 9)
        return rows


@compiled
def into(solid: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vector of the world frame in the solid's axes."""
    return (
        solid[7] * x + solid[10] * y + solid[13] * z,
        solid[8] * x + solid[11] * y + solid[14] * z,
        solid[9] * x + solid[12] * y + solid[15] * z,
    )


@compiled
def attach(parts: Floats, placements: Floats, carriers: Rows, solids: Floats) -> None:
    """Transform solids, shape (k, 16), from their links' frames to the world frame.

    Args:
        parts: Rows of the solids in their links' frames, shape (k, 16).
        placements: Placements of the links, as in ``Engine``, shape (links, 12).
        carriers: Rows of the links that carry them, shape (k,).
        solids: Output: rows in the world frame, shape (k, 16).
    """
    for index in range(len(parts)):
        part, own, place = parts[index], solids[index], placements[carriers[index]]
        for i in range(4):
            own[i] = part[i]
        for i in range(3):
            own[4 + i] = place[9 + i]
            for k in range(3):
                own[4 + i] += place[3 * i + k] * part[4 + k]
                own[7 + 3 * i + k] = (
                    place[3 * i] * part[7 + k]
                    + place[3 * i + 1] * part[10 + k]
                    + place[3 * i + 2] * part[13 + k]
                )
