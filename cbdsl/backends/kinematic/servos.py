"""Ideal servos: joints are where their references are, as far as speeds and limits allow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.links import Links
from cbdsl.robot.compiled import compiled_once
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
        reached = np.empty(len(positions))
        _follow(positions, reference, self._step, self._lower, self._upper, reached)
        return reached


@compiled_once
def _follow(
    positions: Floats,
    reference: Floats,
    step: Floats,
    lower: Floats,
    upper: Floats,
    reached: Floats,
) -> None:
    for joint in range(len(positions)):
        least, most = positions[joint] - step[joint], positions[joint] + step[joint]
        wanted = min(max(reference[joint], least), most)
        reached[joint] = min(max(wanted, lower[joint]), upper[joint])
