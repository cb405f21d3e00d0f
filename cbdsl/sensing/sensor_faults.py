"""Detection of sensor values that are not finite or too large."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.sensing.observation import Observation


class SensorError(Exception):
    """NaN or infinity from a sensor, which the message names."""


def require_finite(
    observation: Observation, wrenches: Floats, robot: RobotDocument, joints: tuple[str, ...]
) -> None:
    """Raise an error for an observation with a number that is not finite or too large.

    Args:
        observation: Observation of one tick.
        wrenches: All loads of the observation, N and N m, shape (k, 6).
        robot: Document of the robot with these sensors.
        joints: Joint names in the order of the observation.

    Raises:
        SensorError: A number is not finite or too large; the message names the sensor.
    """
    if _have_squares(observation.positions, observation.velocities, wrenches):
        return
    measured = {"position": observation.positions, "velocity": observation.velocities}
    for what, values in measured.items():
        if not math.isfinite(values.dot(values)):
            joint = joints[int(np.argmax(np.abs(values)))]
            raise SensorError(f"the {what} of {_owner(joint, robot)} is not finite")
    for (hand, finger), load in observation.loads.items():
        if not math.isfinite(load.dot(load)):
            raise SensorError(f"the load cell {hand}.{finger} is not finite")
    raise SensorError("the sensors' numbers are too large to compute with")


def _owner(joint: str, robot: RobotDocument) -> str:
    """Return a description of a joint with the effector that it belongs to."""
    effectors = robot.effectors.items()
    return next(f"joint {joint} of {name}" for name, each in effectors if joint in each.joints)


@compiled_once
def _have_squares(positions: Floats, velocities: Floats, wrenches: Floats) -> bool:
    """Return whether all numbers are finite and their squares have a finite sum."""
    squares = _square(positions) + _square(velocities)
    for wrench in wrenches:
        squares += _square(wrench)
    return math.isfinite(squares)


@compiled
def _square(numbers: Floats) -> float:
    total = 0.0
    for number in numbers:
        total += number * number
    return total
