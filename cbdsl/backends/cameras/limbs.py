"""Limbs: the parts of arms that may occlude objects."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from cbdsl.backends.staging.shape import SolidShape
from cbdsl.backends.staging.solids import WIDTH, solid_row
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfModel, UrdfShape

# Joints at the end of an arm whose links are wide, and often in front of the cameras.
_WRIST = 3


class Limbs:
    """Wrists and the links beyond them.

    Attributes:
        parts: Solids in the frames of their links, shape (parts, 16).
        links: Names of these links.
    """

    def __init__(self, robot: RobotDocument, model: UrdfModel) -> None:
        arms = [effector for effector in robot.effectors.values() if effector.tip is not None]
        parts = [
            (link, solid)
            for arm in arms
            for link, body in model.bodies.items()
            # All joints but the last two carry the first link of a wrist with three joints.
            if set(model.above(link)).issuperset(arm.joints[: 1 - _WRIST])
            for solid in solid_shapes(body.collisions)
        ]
        self.links = tuple(link for link, _ in parts)
        self.parts: Floats = np.array([solid_row(*solid) for _, solid in parts])
        self.parts = self.parts.reshape(len(parts), WIDTH)


def solid_shapes(shapes: Iterable[UrdfShape]) -> Iterator[tuple[SolidShape, Pose]]:
    """Yield balls, boxes and cylinders among shapes, with their poses in the link's frame."""
    for shape in shapes:
        pose = Pose.at(shape.origin)
        if shape.kind == "ball":
            yield SolidShape.ball(shape.size[0]), pose
        elif shape.kind == "cylinder":
            radius, height = shape.size
            yield SolidShape.cylinder(radius, height), pose
        elif shape.kind == "box":
            x, y, z = (edge / 2 for edge in shape.size)
            yield SolidShape("box", (x, y, z)), pose
