"""Interface of LeRobot's robots, by structure: nothing of LeRobot is imported."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

#: Methods of the interface.
METHODS = ("connect", "get_observation", "send_action", "disconnect")


class LeRobot(Protocol):
    """A robot that is connected, read, commanded and disconnected.

    Observations and actions are flat dictionaries. The keys that a backend reads are

    - ``JOINT.pos``: position of an actuated joint, rad or m;
    - ``JOINT.vel``: its velocity, rad/s or m/s, optional;
    - ``HAND.FINGER.force.x`` to ``HAND.FINGER.torque.z``: wrench of a load cell, N and N m, in the
      axes of its link;
    - ``CAMERA``: RGB image, shape (height, width, 3), of bytes.

    An action has the key ``JOINT.pos`` of each actuated joint.
    """

    def connect(self) -> None:
        """Connect to the hardware."""
        ...

    def get_observation(self) -> Mapping[str, Any]:
        """Return the newest values of all sensors."""
        ...

    def send_action(self, action: dict[str, float], /) -> Any:
        """Send joint references."""
        ...

    def disconnect(self) -> None:
        """Leave the hardware in a safe state, and free it."""
        ...


def robot_name(robot: LeRobot) -> str:
    """Return the name of a robot for messages: its attribute ``name``, or its class."""
    return str(getattr(robot, "name", None) or type(robot).__name__)
