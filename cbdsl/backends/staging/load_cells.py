"""Fingertip load cells: sums of contact forces, noise and a low-pass filter."""

# Model: a reading y follows the wrench x with noise of the standard deviation s,
#     y <- y + g (x + s e - y),    g = 1 - exp(-dt / T)
# for the sampling period dt and the time constant T. In the steady state the noise of y has the
# variance s^2 g / (2 - g). The robot file states s for a cell that samples with the physics. Slower
# sampling has a larger g, so s is scaled such that the variance of y is the same.

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.documents.robot import Contact
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.observation import Cell, Loads

Triple = tuple[float, float, float]

#: Errors of the torques per error of the forces, m: about the radius of a fingertip.
LEVER = 0.012


class ContactPoint(NamedTuple):
    """Contact point of a fingertip.

    Attributes:
        cell: Load cell of the fingertip.
        other: The engine's number of the touched body.
        point: Point on the fingertip, world frame, m.
        force: Force that the fingertip exerts there, world frame, N.
        pressure: Share of the force along the contact normal, N.
    """

    cell: Cell
    other: int
    point: Triple
    force: Triple
    pressure: float


def sum_wrenches(
    cells: tuple[Cell, ...], touches: Sequence[ContactPoint], origins: Mapping[Cell, Triple]
) -> Floats:
    """Return the wrench of each fingertip on the world, world frame, shape (cells, 6).

    Force, N, then torque about the fingertip's origin, N m.
    """
    sums = np.zeros((len(cells), 6))
    for touch in touches:
        # Torque about the fingertip's origin: lever x force.
        ox, oy, oz = origins[touch.cell]
        x, y, z = touch.point[0] - ox, touch.point[1] - oy, touch.point[2] - oz
        fx, fy, fz = touch.force
        torque = (y * fz - z * fy, z * fx - x * fz, x * fy - y * fx)
        sums[cells.index(touch.cell)] += (*touch.force, *torque)
    return sums


class LoadCells:
    """Noisy readings of wrenches behind a first-order low-pass filter.

    Fewer samples give equivalent readings: lag and noise after the filter are the same.

    Args:
        cells: Load cells, as (hand, finger).
        contact: Noise of a cell that samples with the physics, and time constant of the filter.
        periods: Period between two samples here, and between two of such a cell, s.
        rng: Generator of the noise.
        ahead: Number of samples for which noise is drawn at a time.
    """

    def __init__(
        self,
        cells: tuple[Cell, ...],
        contact: Contact,
        periods: tuple[float, float],
        rng: np.random.Generator,
        ahead: int = 1,
    ) -> None:
        self._cells = cells
        self._gain, often = (_gain(contact.filter, period) for period in periods)
        passed = often / (2 - often) / (self._gain / (2 - self._gain))
        levers = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
        self._noise = contact.noise * math.sqrt(passed) * levers
        self._rng = rng
        self._readings: Floats = np.zeros((len(cells), 6))
        self._ahead, self._samples = ahead, 0

    def sample(self, wrenches: Floats) -> None:
        """Process one sample of the wrenches, shape (cells, 6)."""
        index = self._samples % self._ahead
        if index == 0:
            self._drawn = self._rng.standard_normal((self._ahead, *self._readings.shape))
        before, self._readings = self._readings, self._drawn[index]
        _filter(before, wrenches, self._noise, self._gain, self._readings)
        self._samples += 1

    def read(self) -> Loads:
        """Return each fingertip's force, N, and torque, N m, world frame, shape (6,) each."""
        return Loads(self._cells, self._readings)


@compiled_once
def _filter(before: Floats, wrenches: Floats, noise: Floats, gain: float, after: Floats) -> None:
    """Filter readings, shape (cells, 6); ``after`` holds unit noise, then the new readings."""
    for cell in range(len(before)):
        for part in range(6):
            sample = wrenches[cell, part] + noise[part] * after[cell, part]
            after[cell, part] = before[cell, part] + gain * (sample - before[cell, part])


def _gain(time_constant: float, period: float) -> float:
    """Return the share of a step that passes the filter within one period, s."""
    return -math.expm1(-period / time_constant) if time_constant else 1.0
