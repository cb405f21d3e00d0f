"""Encoders: joint positions in steps, and velocities by their differences."""

from __future__ import annotations

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once


class Encoders:
    """Encoders of a robot's actuated joints.

    Args:
        robot: Robot document, with the resolutions by effector.
        period: Period between two readings, s.
    """

    def __init__(self, robot: RobotDocument, period: float) -> None:
        self._steps = np.array(
            [each.resolution for each in robot.effectors.values() for _ in each.joints]
        )
        self._period = period

    def begin(self, positions: Floats) -> tuple[Floats, Floats]:
        """Return the first reading of joints at rest; see ``read``."""
        # The difference to the true position is rounding, and no velocity.
        self._before = positions
        self._before, _ = self.read(positions)
        return self._before, np.zeros_like(positions)

    def read(self, positions: Floats) -> tuple[Floats, Floats]:
        """Read the joints, one period after the last reading.

        Args:
            positions: True positions, rad or m, shape (n,).

        Returns:
            Positions and velocities, rad and rad/s or m and m/s, shape (n,) each.
        """
        read, velocities = np.empty_like(positions), np.empty_like(positions)
        _read(positions, self._steps, self._period, self._before, read, velocities)
        self._before = read
        return read, velocities


@compiled_once
def _read(
    positions: Floats,
    steps: Floats,
    period: float,
    before: Floats,
    read: Floats,
    velocities: Floats,
) -> None:
    """Round positions to steps, and compute velocities since ``before``."""
    for joint in range(len(positions)):
        # Both readings are multiples of the step, so velocities are multiples of step / period.
        step = steps[joint]
        read[joint] = round(positions[joint] / step) * step if step > 0.0 else positions[joint]
        velocities[joint] = (read[joint] - before[joint]) / period
