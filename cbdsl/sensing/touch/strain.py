"""Strain: joint torques due to contacts anywhere on the robot."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.documents.robot import JointTorques
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.observation import Observation


class Strain:
    """Torques that the joints' drives exert beyond the weight of the links, low-pass filtered.

    A held object counts as a contact, and so do accelerations. The filter and the threshold in the
    robot document keep accelerations below a guard. Strain is computed only if it is needed.

    Attributes:
        torques: Joint torques that the robot exerts on the world, N m, shape (n,).
        needed: True if the torques are used.
    """

    def __init__(self, settings: JointTorques | None, kinematics: Kinematics) -> None:
        self._settings, self._kinematics = settings, kinematics
        self.torques: Floats = np.zeros(len(kinematics.joints))
        self.needed = False
        self.reset()

    def reset(self) -> None:
        """Forget the previous episode."""
        self.torques[:] = 0.0
        self._time = math.nan

    def update(self, observation: Observation) -> None:
        """Update from one tick's torques; the kinematics must have its posture."""
        if not self.needed or self._settings is None or observation.efforts is None:
            return
        passed, self._time = observation.time - self._time, observation.time
        if not passed > 0.0:
            return  # no drive has exerted a torque before the first step
        share = 1.0 - math.exp(-passed / self._settings.filter) if self._settings.filter else 1.0
        self.torques += share * (observation.efforts - self._kinematics.weight() - self.torques)
