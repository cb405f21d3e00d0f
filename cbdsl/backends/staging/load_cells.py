"""Fingertip load cells: sums of contact forces, noise and a low-pass filter."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Contact
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.observation import Cell, Loads

Floats = NDArray[np.float64]
Triple = tuple[float, float, float]

#: Errors of the torques per error of the forces, m: about the radius of a fingertip.
LEVER = 0.012


class ContactPoint(NamedTuple):
    """One contact point of a fingertip.

    Attributes:
        cell: the fingertip's load cell.
        other: the engine's number of what is touched.
        point: on the fingertip, in the world frame, m.
        force: that the fingertip exerts there, in the world frame, N.
        pressure: the force's share along the contact normal, N.
    """

    cell: Cell
    other: int
    point: Triple
    force: Triple
    pressure: float


def sum_wrenches(
    cells: tuple[Cell, ...], touches: Sequence[ContactPoint], origins: Mapping[Cell, Triple]
) -> Floats:
    """Wrench of each fingertip on the world, world frame, shape (cells, 6).

    Force, N, then torque about the fingertip's origin, N m.
    """
    sums = np.zeros((len(cells), 6))
    for touch in touches:
        ox, oy, oz = origins[touch.cell]
        x, y, z = touch.point[0] - ox, touch.point[1] - oy, touch.point[2] - oz
        fx, fy, fz = touch.force
        torque = (y * fz - z * fy, z * fx - x * fz, x * fy - y * fx)
        sums[cells.index(touch.cell)] += (*touch.force, *torque)
    return sums


class LoadCells:
    """Noisy readings of wrenches behind a first-order low-pass filter.

    Whoever takes fewer samples reads as much: the filter lags as much, and as much noise passes.

    Args:
        cells: the load cells, as (hand, finger).
        contact: noise of a cell that samples with the physics, and time constant of the filter.
        periods: between two samples here, and between two of such a cell, s.
        rng: draws the noise.
        ahead: for how many samples noise is drawn at once.
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
        """Take in one sample of the wrenches, shape (cells, 6)."""
        index = self._samples % self._ahead
        if index == 0:
            self._drawn = self._rng.standard_normal((self._ahead, *self._readings.shape))
        before, self._readings = self._readings, self._drawn[index]
        _filter(before, wrenches, self._noise, self._gain, self._readings)
        self._samples += 1

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


def _gain(time_constant: float, period: float) -> float:
    """Share of a step that passes the filter within one period, s."""
    return -math.expm1(-period / time_constant) if time_constant else 1.0
