"""Offsets of load cells: their readings without contact."""

# Model: a load cell without contact reads, in the world frame,
#     R b(t) + (w, R l x w),    w = (0, 0, m g)
# with the rotation R of the cell, its bias b, and the lever l to the tip's centre of mass. The bias
# starts from a normal draw and walks at random. Its standard deviation grows by drift * sqrt(t), at
# any control rate. The weight turns in the cell's frame while the hand turns, so that no constant
# offset cancels it. Assumption: accelerations of the tip are neglected.

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cbdsl.backends.staging.load_cells import LEVER
from cbdsl.backends.staging.scenario import GRAVITY
from cbdsl.documents.robot import Contact
from cbdsl.numeric.arrays import Floats, Rows
from cbdsl.numeric.compiled import compiled_once
from cbdsl.robot.urdf import UrdfLink

# Number of ticks for which drift is drawn at a time.
_AHEAD = 64


class CellOffsets:
    """Bias, drift and the tips' weight, which load cells add to the wrenches of contacts.

    A bias is fixed in the frame of its cell, and drifts. The weight is constant in the world.

    Args:
        tips: Links that carry the cells.
        rows: Rows of these links in the placements of an engine.
        contact: Sizes of bias and drift.
        period: Control period, s.
        rng: Generator of bias and drift.
    """

    def __init__(
        self,
        tips: Sequence[UrdfLink],
        rows: Sequence[int],
        contact: Contact,
        period: float,
        rng: np.random.Generator,
    ) -> None:
        self._rows = np.array(rows, dtype=np.intp)
        bodies = [tip.inertial for tip in tips]
        self._weights = np.array([GRAVITY * body.mass if body else 0.0 for body in bodies])
        levers = [body.origin.xyz if body else (0.0, 0.0, 0.0) for body in bodies]
        self._levers = np.array(levers).reshape(len(tips), 3)
        sizes = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
        self._bias = contact.bias * sizes * rng.standard_normal((len(tips), 6))
        self._wander = contact.drift * math.sqrt(period) * sizes
        self._rng, self._ticks = rng, 0

    def drift(self) -> None:
        """Advance the drift by one control period."""
        index = self._ticks % _AHEAD
        if index == 0:
            steps = self._rng.standard_normal((_AHEAD, *self._bias.shape)) * self._wander
            # Noise is drawn for many ticks in one call, since each call has a fixed cost.
            self._path = self._bias + np.cumsum(steps, axis=0)
        self._bias = self._path[index]
        self._ticks += 1

    def added(self, wrenches: Floats, placements: Floats) -> Floats:
        """Return wrenches with the offsets.

        Args:
            wrenches: Wrenches of contacts, N and N m, world frame, shape (cells, 6).
            placements: Placements of the links, as in ``Engine``, shape (links, 12).
        """
        sums = wrenches.copy()
        _add(placements, self._rows, self._bias, self._weights, self._levers, sums)
        return sums


@compiled_once
def _add(
    placements: Floats, rows: Rows, bias: Floats, weights: Floats, levers: Floats, sums: Floats
) -> None:
    """Add biases, in the cells' frames, and weights, N, behind levers there, m, to wrenches."""
    for cell in range(len(rows)):
        place = placements[rows[cell]]
        # The support of a weight pushes upwards.
        weight = weights[cell]
        x = y = 0.0
        for k in range(3):
            x += place[k] * levers[cell, k]
            y += place[3 + k] * levers[cell, k]
        sums[cell, 2] += weight
        sums[cell, 3] += y * weight
        sums[cell, 4] -= x * weight
        for i in range(3):
            for k in range(3):
                sums[cell, i] += place[3 * i + k] * bias[cell, k]
                sums[cell, 3 + i] += place[3 * i + k] * bias[cell, 3 + k]
