"""Numbers of sensors that nothing can be computed with."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.sensing.observation import Observation

Floats = NDArray[np.float64]


class SensorError(Exception):
    """A sensor gave NaN or infinity; the message names it."""


def require_finite(
    observation: Observation, wrenches: Floats, robot: RobotDocument, joints: tuple[str, ...]
) -> None:
    """Refuse an observation with a number that is not finite, or too large to compute with.

    Args:
        observation: of one tick.
        wrenches: all of its loads, N and N m, shape (k, 6).
        robot: whose sensors they are.
        joints: names in the order of the observation.

    Raises:
        SensorError: it names the sensor.
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
    """A joint, and the resource that it belongs to."""
    effectors = robot.effectors.items()
    return next(f"joint {joint} of {name}" for name, each in effectors if joint in each.joints)


@compiled_once
def _have_squares(positions: Floats, velocities: Floats, wrenches: Floats) -> bool:
    """Whether all numbers are finite, and small enough to compute with."""
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
