"""The fingertip load cells: what they read of the forces that act on them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.bullet.touch import Fingertips
from cbdsl.documents.robot import Contact
from cbdsl.sensing.observation import Loads

Floats = NDArray[np.float64]

#: Noise of the torques per noise of the forces, m: about the radius of a fingertip.
_LEVER = 0.012


class LoadCells:
    """Noisy readings of the fingertips' wrenches behind a first-order low-pass filter.

    Args:
        fingertips: where the forces act.
        contact: the cells' noise, before the filter, and the filter's time constant.
        period: time between two samples, s.
        rng: draws the noise.
    """

    def __init__(
        self, fingertips: Fingertips, contact: Contact, period: float, rng: np.random.Generator
    ) -> None:
        self._fingertips = fingertips
        self._noise = contact.noise * np.array([1.0, 1.0, 1.0, _LEVER, _LEVER, _LEVER])
        self._gain = -math.expm1(-period / contact.filter) if contact.filter else 1.0
        self._rng = rng
        self._readings: Floats = np.zeros((len(fingertips.cells), 6))

    def sample(self) -> None:
        """Take in one sample; to be called once per physics step."""
        noise = self._noise * self._rng.standard_normal(self._readings.shape)
        self._readings += self._gain * (self._fingertips.wrenches() + noise - self._readings)

    def read(self) -> Loads:
        """Force, N, and torque, N m, that each fingertip exerts, world frame, shape (6,) each."""
        return Loads(self._fingertips.cells, self._readings.copy())
