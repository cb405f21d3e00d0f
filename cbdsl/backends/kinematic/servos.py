"""Ideal servos: joints are where their references are, as far as speeds and limits allow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.links import Links
from cbdsl.robot.kinematics import Kinematics

Floats = NDArray[np.float64]


class Servos:
    """The servos of all actuated joints.

    Args:
        kinematics: knows the joints and their limits.
        links: knows their speed limits.
        period: of a control tick, s.
    """

    def __init__(self, kinematics: Kinematics, links: Links, period: float) -> None:
        speeds = np.array([links.speeds[name] for name in kinematics.joints.names])
        self._step = period * speeds
        self._lower, self._upper = kinematics.lower, kinematics.upper

    def follow(self, positions: Floats, reference: Floats) -> Floats:
        """Where the joints are a tick later, rad, shape (n,) each."""
        reached = np.minimum(np.maximum(reference, positions - self._step), positions + self._step)
        limited: Floats = np.minimum(np.maximum(reached, self._lower), self._upper)
        return limited
