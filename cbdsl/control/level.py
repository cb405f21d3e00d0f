"""Contribution of one controller to the law in one tick."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Floats


class LevelArrays(NamedTuple):
    """Levels of a stack in the form of compiled code: k task coordinates of n joints.

    Attributes:
        clock: Index of this tick among the three, shape (1,); the preceding tick is one less,
            modulo 3.
        rows: Task coordinates per joint in three ticks, highest priority first, shape (3, k, n).
        ages: Number of ticks for which each level has rows, up to 3; 0 for a level that does not
            act, shape (levels,).
        requested: Requested displacement of the task coordinates in this tick, shape (k,).
        ends: Index after the last row of each level, shape (levels,).
        fractions: Share of the way to its target that each level requests in a tick, above 0 and
            at most 1, shape (levels,).
        errors: Distance of each level from its target, in its coordinates' unit, shape (levels,).
        curved: True for levels whose coordinates have Hessians, shape (levels,).
        hessians: Second derivatives of the task coordinates by the joints, shape (k, n, n).
        withheld: Number of directions that each level withheld from those below in the preceding
            tick, because it resists them, shape (levels,).
        bent: True if a level used its Hessians in the preceding tick, shape (1,).
        sides: 0 for rows that request a displacement. 1 for rows whose bound allows it at most, -1
            for rows whose bound requires it at least, shape (k,).
        idle: True for rows of bounds that no level reached in this tick, shape (k,).
    """

    clock: NDArray[np.int64]
    rows: Floats
    ages: NDArray[np.int64]
    requested: Floats
    ends: NDArray[np.int64]
    fractions: Floats
    errors: Floats
    curved: NDArray[np.bool_]
    hessians: Floats
    withheld: NDArray[np.int64]
    bent: NDArray[np.bool_]
    sides: Floats
    idle: NDArray[np.bool_]


class Level(NamedTuple):
    """Displacement that one controller requests in a tick, with its Jacobian.

    Attributes:
        name: Controller, for messages and explanations.
        jacobian: Task coordinates per joint, shape (k, n).
        velocity: Requested displacement of the task coordinates in this tick, gain and bounds
            applied, shape (k,).
        hessian: Second derivatives of the task coordinates by the joints, shape (k, n, n); ``None``
            for coordinates that count as linear.
        fraction: Share of the way to the target that the displacement is, above 0 and at most 1.
    """

    name: str
    jacobian: Floats
    velocity: Floats
    hessian: Floats | None = None
    fraction: float = 1.0
