"""Noise of load cells: the least force that they tell from it."""

from __future__ import annotations

from cbdsl.documents.robot import RobotDocument

# A reading of noise alone is hardly ever as many standard deviations away from 0.
_DEVIATIONS = 5.0


def least_force(robot: RobotDocument) -> float:
    """The force, N, up to which a robot takes what its load cells read for noise."""
    return max(robot.contact.threshold, _DEVIATIONS * robot.contact.noise)
