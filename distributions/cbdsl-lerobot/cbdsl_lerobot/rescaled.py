"""Robot of LeRobot in SI units, from any units of its motors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from cbdsl_lerobot.robot_interface import LeRobot, robot_name

#: Radians of a degree.
DEGREES = math.pi / 180


class Scale(NamedTuple):
    """Linear map from a motor's value to a joint's position: ``unit * (value - zero)``.

    Attributes:
        motor: Name of the motor, whose key is ``MOTOR.pos``.
        unit: Radians or metres of one unit of the motor; negative if it turns against the joint.
        zero: Value of the motor where the joint's position is 0.
    """

    motor: str
    unit: float = DEGREES
    zero: float = 0.0


class Rescaled:
    """Robot whose joints have the names and units of a URDF; see ``LeRobot``.

    Keys without a scale, such as those of cameras, pass unchanged.

    Args:
        robot: Robot with motors in degrees, percent or other units.
        scales: Map of each joint, by the joint's name.

    Raises:
        ValueError: The unit of a joint is 0 or not finite.
    """

    def __init__(self, robot: LeRobot, scales: Mapping[str, Scale]) -> None:
        self._robot, self._scales = robot, dict(scales)
        self.name = robot_name(robot)
        for joint, scale in self._scales.items():
            if not scale.unit or not math.isfinite(scale.unit + scale.zero):
                raise ValueError(f"the scale of joint '{joint}' is {scale}: unit 0, or not finite")

    def connect(self) -> None:
        """Connect the robot."""
        self._robot.connect()

    def get_observation(self) -> dict[str, Any]:
        """Return the robot's observation with joints in SI units."""
        observation = dict(self._robot.get_observation())
        joints: dict[str, float] = {}
        for joint, scale in self._scales.items():
            for key, zero in (("pos", scale.zero), ("vel", 0.0)):
                value = observation.pop(f"{scale.motor}.{key}", None)
                if value is not None:
                    joints[f"{joint}.{key}"] = scale.unit * (value - zero)
        return observation | joints

    def send_action(self, action: dict[str, float], /) -> Any:
        """Send joint references in SI units."""
        others, motors = dict(action), {}
        for joint, scale in self._scales.items():
            position = others.pop(f"{joint}.pos", None)
            if position is not None:
                motors[f"{scale.motor}.pos"] = scale.zero + position / scale.unit
        return self._robot.send_action(others | motors)

    def disconnect(self) -> None:
        """Disconnect the robot."""
        self._robot.disconnect()
