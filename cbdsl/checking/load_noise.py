"""Noise of load cells: the least force that can be distinguished from it."""

from __future__ import annotations

from cbdsl.documents.robot import RobotDocument

# Noise alone hardly ever causes a reading of this many standard deviations.
_DEVIATIONS = 5.0


def least_force(robot: RobotDocument) -> float:
    """Return the force up to which a robot takes readings of its load cells for noise, N."""
    return max(robot.contact.threshold, _DEVIATIONS * robot.contact.noise)
