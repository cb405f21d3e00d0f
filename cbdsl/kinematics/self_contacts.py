"""Self-contacts of a robot: pairs of links that touch in one posture, or in all of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from cbdsl.kinematics.joint_tree import JointTree
from cbdsl.kinematics.link_shapes import convex_hull
from cbdsl.kinematics.pose import Pose
from cbdsl.robot.link_place import at_first
from cbdsl.robot.urdf import UrdfJoint, UrdfModel, UrdfShape

LinkPair = tuple[str, str]

# Contact margin of engines before shapes overlap, m.
_MARGIN = 0.002
# Number of sampled postures, and largest turn of unlimited joints in them, rad.
_SAMPLES = 100
_TURN = math.pi


class ConvexPart(NamedTuple):
    """Convex part of a link.

    Attributes:
        geometry: Geometry of coal.
        pose: Pose in the link's frame.
    """

    geometry: Any
    pose: Pose


class SelfContacts:
    """Contacts between links of which neither carries the other, as in physics engines.

    Meshes are replaced by their convex hulls, as engines do; unreadable ones are left out.

    Args:
        model: Model of the robot.

    Raises:
        ImportError: If the reader of meshes, coal, is not installed.
        UrdfError: If a value of a link is not a number.
    """

    def __init__(self, model: UrdfModel) -> None:
        import coal  # installed with Pinocchio

        self._coal, self._model = coal, model
        self._tree = JointTree(joint for root in model.roots for joint in model.beyond(root))
        shapes = {name: [*self._shapes(body.collisions)] for name, body in model.bodies.items()}
        self._shapes_of = {name: own for name, own in shapes.items() if own}
        carried = model.carried_pairs()
        self._pairs = [
            (one, other)
            for one, other in combinations(sorted(self._shapes_of), 2)
            if (one, other) not in carried
        ]
        self._request = coal.CollisionRequest()
        self._request.security_margin = _MARGIN

    def touching(self, positions: Mapping[str, float]) -> frozenset[LinkPair]:
        """Return the pairs of links that touch in a posture.

        Args:
            positions: Positions of joints, rad or m; other joints are at their initial positions.
        """
        return self._touching(positions, self._pairs)

    def always(self) -> frozenset[LinkPair]:
        """Return the pairs of links that touch in all of a hundred random postures."""
        rng, left = np.random.default_rng(0), frozenset(self._pairs)
        for _ in range(_SAMPLES):
            if not left:
                break
            drawn = {joint.name: _drawn(joint, rng) for joint in self._tree.joints if joint.movable}
            # Only pairs that touched in all postures so far are tested, and few remain after the
            # first ones.
            left = self._touching(drawn, sorted(left))
        return left

    def _touching(
        self, positions: Mapping[str, float], pairs: list[LinkPair]
    ) -> frozenset[LinkPair]:
        joints = [joint for joint in self._tree.joints if joint.movable]
        links = self._tree.place({joint.name: self._position(joint, positions) for joint in joints})
        placed = {}
        for name, shapes in self._shapes_of.items():
            poses = [links[name].child @ s.pose if name in links else s.pose for s in shapes]
            transforms = [self._coal.Transform3s(pose.rotation, pose.position) for pose in poses]
            placed[name] = [(s.geometry, at) for s, at in zip(shapes, transforms, strict=True)]
        return frozenset(
            (one, other)
            for one, other in pairs
            if any(self._touch(*a, *b) for a in placed[one] for b in placed[other])
        )

    def _touch(self, one: Any, its_pose: Any, other: Any, other_pose: Any) -> bool:
        result = self._coal.CollisionResult()
        return bool(self._coal.collide(one, its_pose, other, other_pose, self._request, result))

    def _position(self, joint: UrdfJoint, positions: Mapping[str, float]) -> float:
        """Return the position of a joint; a passive one follows another."""
        mimic = joint.mimic
        if mimic is None or mimic.joint not in self._model.joints:
            return positions.get(joint.name, at_first(joint))
        leader = self._model.joints[mimic.joint]
        return mimic.ratio * positions.get(leader.name, at_first(leader)) + mimic.offset

    def _shapes(self, shapes: tuple[UrdfShape, ...]) -> Iterator[ConvexPart]:
        for shape in shapes:
            geometry = self._geometry(shape)
            if geometry is not None:
                yield ConvexPart(geometry, Pose.at(shape.origin))

    def _geometry(self, shape: UrdfShape) -> Any:
        """Return the coal geometry of a shape, or ``None`` if it has no volume."""
        if shape.kind == "mesh":
            return convex_hull(shape, self._model.path.parent)
        if not all(size > 0 for size in shape.size):
            return None
        make = {"ball": "Sphere", "box": "Box", "cylinder": "Cylinder", "capsule": "Capsule"}
        return getattr(self._coal, make[shape.kind])(*shape.size)


def _drawn(joint: UrdfJoint, rng: np.random.Generator) -> float:
    return float(rng.uniform(max(joint.lower, -_TURN), min(joint.upper, _TURN)))
