"""What is in the world besides the robot: the fixtures of a stage and the thing on show."""

from __future__ import annotations

import pybullet as p

from cbdsl.backends.bullet.shape import Shape
from cbdsl.backends.pose import Pose
from cbdsl.documents.stage import Surface

#: Acceleration of falling things, m/s^2.
GRAVITY = 9.81


class Scene:
    """The bodies that a stage put into the world, by name.

    Attributes:
        bodies: the simulator's number of each.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        self.bodies: dict[str, int] = {}

    def add(self, name: str, shape: Shape, surface: Surface, mass: float, pose: Pose) -> int:
        """Put a body there; without mass it does not move."""
        body = shape.create(
            self._client, mass, surface.color, pose.position.tolist(), pose.quaternion()
        )
        self.bodies[name] = body
        p.changeDynamics(
            body,
            -1,
            lateralFriction=surface.friction,
            rollingFriction=surface.rolling_friction,
            spinningFriction=surface.rolling_friction,
            linearDamping=0,
            angularDamping=0,
            physicsClientId=self._client,
        )
        return body

    def remove(self, name: str) -> None:
        """Take a body out of the world."""
        p.removeBody(self.bodies.pop(name), physicsClientId=self._client)
