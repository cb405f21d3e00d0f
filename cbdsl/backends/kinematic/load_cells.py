"""The fingertip load cells: what they read of the forces that act on them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.observation import Cell, Loads

Floats = NDArray[np.float64]

#: Noise of the torques per noise of the forces, m: about the radius of a fingertip.
_LEVER = 0.012
# For how many ticks noise is drawn at once.
_AHEAD = 64


class LoadCells:
    """Noisy readings of wrenches behind a first-order low-pass filter.

    They read once per control tick what cells that sample at the physics rate would read: the
    filter lags as much, and as much noise passes it.

    Args:
        cells: the load cells, as (hand, finger).
        robot: states the cells' noise and filter, and the physics rate.
        period: of the control ticks, s.
        rng: draws the noise.
    """

    def __init__(
        self,
        cells: tuple[Cell, ...],
        robot: RobotDocument,
        period: float,
        rng: np.random.Generator,
    ) -> None:
        contact = robot.contact
        self._cells = cells
        self._gain = _gain(contact.filter, 1 / period)
        often = _gain(contact.filter, robot.simulation.physics_rate)
        passed = often / (2 - often) / (self._gain / (2 - self._gain))
        levers = np.array([1.0, 1.0, 1.0, _LEVER, _LEVER, _LEVER])
        self._noise = contact.noise * math.sqrt(passed) * levers
        self._rng = rng
        self._readings: Floats = np.zeros((len(cells), 6))
        self._ticks = 0

    def sample(self, wrenches: Floats) -> None:
        """Take in the wrenches of one control tick, shape (cells, 6)."""
        tick = self._ticks % _AHEAD
        if tick == 0:
            self._drawn = self._rng.standard_normal((_AHEAD, *self._readings.shape))
        before, self._readings = self._readings, self._drawn[tick]
        _filter(before, wrenches, self._noise, self._gain, self._readings)
        self._ticks += 1

    def read(self) -> Loads:
        """Force, N, and torque, N m, that each fingertip exerts, world frame, shape (6,) each."""
        return Loads(self._cells, self._readings)


@compiled_once
def _filter(before: Floats, wrenches: Floats, noise: Floats, gain: float, after: Floats) -> None:
    """The readings after those before, shape (cells, 6); ``after`` brings unit noise."""
    for cell in range(len(before)):
        for part in range(6):
            sample = wrenches[cell, part] + noise[part] * after[cell, part]
            after[cell, part] = before[cell, part] + gain * (sample - before[cell, part])


def _gain(time_constant: float, rate: float) -> float:
    """Share of a step that passes the filter within one of ``rate`` samples a second."""
    return -math.expm1(-1 / (rate * time_constant)) if time_constant else 1.0
