"""What only the simulator knows. The experimenter and tests may ask; no observation tells."""

from __future__ import annotations

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.bullet.body import Body
from cbdsl.backends.bullet.scene import Scene
from cbdsl.backends.bullet.touch import Fingertips, Touch
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.scenery import Part

Floats = NDArray[np.float64]

# The simulator counts a cylinder's height before its radius.
_SHAPES = {
    p.GEOM_SPHERE: ("ball", (0,)),
    p.GEOM_BOX: ("box", (0, 1, 2)),
    p.GEOM_CYLINDER: ("cylinder", (1, 0)),
}


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

    def parts(self, name: str) -> list[Part]:
        """The shapes that a fixture or thing is made of."""
        parts = []
        for row in p.getVisualShapeData(self._scene.bodies[name], physicsClientId=self._client):
            shape, order = _SHAPES[row[2]]
            size = tuple(row[3][index] for index in order)
            parts.append(Part(shape, size, row[5], row[6], row[7][:3]))
        return parts

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

    def is_near(self, name: str, distance: float) -> bool:
        """Whether any part of the robot is within a distance of a fixture or thing, m."""
        body = self._scene.bodies[name]
        near = p.getClosestPoints(self._body.id, body, distance, physicsClientId=self._client)
        return bool(near)

    def touched(self, name: str) -> bool:
        """Whether any part of the robot touches a fixture or thing."""
        contacts = p.getContactPoints(
            bodyA=self._body.id, bodyB=self._scene.bodies[name], physicsClientId=self._client
        )
        return any(contact[9] for contact in contacts)
