"""What is in the world besides the robot: the fixtures of a stage and the thing on show."""

from __future__ import annotations

import pybullet as p

from cbdsl.backends.bullet.pose import Pose
from cbdsl.backends.bullet.shape import Shape
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
        self.restore(body, surface)
        return body

    def restore(self, body: int, surface: Surface) -> None:
        """Give a body the friction of its surface."""
        self._set_friction(body, surface.friction, surface.rolling_friction)

    def make_slippery(self, body: int) -> None:
        """Take a body's friction away."""
        self._set_friction(body, 0.0, 0.0)

    def _set_friction(self, body: int, lateral: float, rolling: float) -> None:
        p.changeDynamics(
            body,
            -1,
            lateralFriction=lateral,
            rollingFriction=rolling,
            spinningFriction=rolling,
            linearDamping=0,
            angularDamping=0,
            physicsClientId=self._client,
        )

    def remove(self, name: str) -> None:
        """Take a body out of the world."""
        p.removeBody(self.bodies.pop(name), physicsClientId=self._client)
