"""What is in the world besides the robot: the fixtures of a stage and the thing on show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pybullet as p

from cbdsl.backends.bullet.printed import create_printed
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.shape import Shape
from cbdsl.documents.stage import Surface

_KINDS = {"ball": p.GEOM_SPHERE, "box": p.GEOM_BOX, "cylinder": p.GEOM_CYLINDER}


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
        body = self._create(shape, mass, surface.color, pose)
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

    def _create(self, shape: Shape, mass: float, color: Sequence[float], pose: Pose) -> int:
        position, quaternion = pose.position.tolist(), pose.quaternion()
        if shape.pattern is not None or shape.spot is not None:
            return create_printed(self._client, shape, mass, color, position, quaternion)
        kind, client = _KINDS[shape.kind], self._client
        # The simulator has two words for a cylinder's extent.
        collision, visual = _size(shape, "height"), _size(shape, "length")
        return int(
            p.createMultiBody(
                mass,
                p.createCollisionShape(kind, physicsClientId=client, **collision),
                p.createVisualShape(kind, rgbaColor=[*color, 1], physicsClientId=client, **visual),
                position,
                quaternion,
                physicsClientId=client,
            )
        )

    def remove(self, name: str) -> None:
        """Take a body out of the world."""
        p.removeBody(self.bodies.pop(name), physicsClientId=self._client)


def _size(shape: Shape, height: str) -> dict[str, Any]:
    """A shape's size by the simulator's names; ``height`` is that of a cylinder's height."""
    if shape.kind == "box":
        return {"halfExtents": shape.halves}
    if shape.kind == "ball":
        return {"radius": shape.halves[0]}
    return {"radius": shape.halves[0], height: 2 * shape.half_height}
