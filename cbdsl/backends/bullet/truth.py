"""What only the simulator knows. The experimenter and tests may ask; no observation tells."""

from __future__ import annotations

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.bullet.body import Body
from cbdsl.backends.bullet.pose import Pose
from cbdsl.backends.bullet.scene import Scene
from cbdsl.backends.bullet.touch import Fingertips, Touch

Floats = NDArray[np.float64]


class Truth:
    """The true state of the world in one episode."""

    def __init__(self, client: int, body: Body, scene: Scene, fingertips: Fingertips) -> None:
        self._client = client
        self._body = body
        self._scene = scene
        self._fingertips = fingertips

    def names(self) -> tuple[str, ...]:
        """What the stage has put into the world and not taken away."""
        return tuple(self._scene.bodies)

    def pose(self, name: str) -> Pose:
        """Where a fixture or thing is: its centre and axes."""
        return Pose.of(
            *p.getBasePositionAndOrientation(self._scene.bodies[name], physicsClientId=self._client)
        )

    def velocity(self, name: str) -> Floats:
        """Velocity of a thing's centre, m/s, shape (3,)."""
        return np.array(
            p.getBaseVelocity(self._scene.bodies[name], physicsClientId=self._client)[0]
        )

    def link_pose(self, link: str) -> Pose:
        """Where a link of the robot, other than its base, really is."""
        return self._body.poses([self._body.link(link)])[0]

    def touches(self, name: str | None = None) -> list[Touch]:
        """Contact points of the fingertips, with everything or with one fixture or thing."""
        touches = self._fingertips.touches()
        if name is None:
            return touches
        return [touch for touch in touches if touch.body == self._scene.bodies[name]]

    def touched(self, name: str) -> bool:
        """Whether any part of the robot touches a fixture or thing."""
        contacts = p.getContactPoints(
            bodyA=self._body.id, bodyB=self._scene.bodies[name], physicsClientId=self._client
        )
        return any(contact[9] for contact in contacts)
