"""The robot's hands in contact: fingertips, and the links that carry them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cbdsl.backends.cameras.limbs import solid_shapes
from cbdsl.backends.kinematic.depths import depths
from cbdsl.backends.kinematic.kinematic_object import KinematicObject
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.links import link_surfaces
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats, Rows
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfLink, UrdfModel

Vector = tuple[float, float, float]

# Friction of links without a surface in the robot file, as of PyBullet's bodies.
_FRICTION = 0.5


class Fingertip(NamedTuple):
    """Ball at the end of a finger.

    Attributes:
        cell: Index of its load cell among all.
        link: Link that carries the ball.
        centre: Centre in the link's frame, m, shape (3,).
        radius: Radius, m.
        friction: Coefficient of friction.
        joints: Indices of the hand's joints that move it.
    """

    cell: int
    link: str
    centre: Floats
    radius: float
    friction: float
    joints: Rows


@dataclass(frozen=True)
class Hand:
    """Fingertips that belong together.

    Attributes:
        name: Name in the robot file.
        carrier: Link that carries all fingers of the hand.
        fingertips: Fingertips, in the order of their load cells.
    """

    name: str
    carrier: str
    fingertips: tuple[Fingertip, ...]


class FingertipContact(NamedTuple):
    """Fingertip pressed into an object.

    Attributes:
        hand: Name of the hand.
        fingertip: Fingertip in contact.
        thing: Object in contact.
        depth: Depth of the undeformed fingertip inside the object, m.
        point: Contact point, world frame, m.
        normal: Unit vector into the object.
    """

    hand: str
    fingertip: Fingertip
    thing: KinematicObject
    depth: float
    point: Vector
    normal: Vector


class Hands:
    """All hands with load cells.

    Attributes:
        cells: Load cells, as (hand, finger), in the robot file's order.
        hands: Hands by name.
    """

    def __init__(
        self, robot: RobotDocument, model: UrdfModel, joints: Joints, tree: LinkTree
    ) -> None:
        self._robot, self._model, self._joints, self._tree = robot, model, joints, tree
        self._surfaces = link_surfaces(robot, model)
        self.cells = tuple(
            (hand, finger) for hand, fingers in robot.load_cells.items() for finger in fingers
        )
        self.hands = {name: self._hand(name) for name in robot.load_cells}
        self._fingertips = [
            (hand.name, tip) for hand in self.hands.values() for tip in hand.fingertips
        ]
        tips = [tip for _, tip in self._fingertips]
        self._carriers = np.array([tree.rows[tip.link] for tip in tips], np.intp)
        self._balls = np.array([[*tip.centre, tip.radius] for tip in tips]).reshape(len(tips), 4)
        #: Joints that move each fingertip within its hand, shape (fingertips, n).
        self.moving = np.zeros((len(tips), len(joints)), np.bool_)
        for row, tip in zip(self.moving, tips, strict=True):
            row[tip.joints] = True

    def _hand(self, name: str) -> Hand:
        fingertips = tuple(
            self._fingertip(self.cells.index((name, finger)), name, cell.link)
            for finger, cell in self._robot.load_cells[name].items()
        )
        return Hand(name, self._carrier(fingertips[0].link), fingertips)

    def _fingertip(self, index: int, hand: str, link: str) -> Fingertip:
        moving = set(self._model.above(link))
        # A fingertip beyond a passive joint is also moved by the joint that leads it.
        followed = {self._robot.couplings[j].follows for j in moving if j in self._robot.couplings}
        own = [j for j in self._robot.joints(hand) if j in moving | followed]
        centre, radius = _ball(self._model.bodies[link])
        joints = self._joints.pick(own)
        return Fingertip(index, link, centre, radius, self._friction(link), joints)

    def _friction(self, link: str) -> float:
        return self._surfaces[link].friction if link in self._surfaces else _FRICTION

    def _carrier(self, link: str) -> str:
        """Return the link at the tip of the arm that moves a fingertip; the base without an arm."""
        moving = set(self._model.above(link))
        for effector in self._robot.effectors.values():
            if effector.tip is not None and moving.issuperset(effector.joints):
                return effector.tip.link
        return self._robot.base

    def cross_axis(self, hands: Sequence[str]) -> int:
        """Return the axis of the first hand that is most orthogonal to the line between two hands.

        It is 0 for a single hand.
        """
        if len(hands) == 1:
            return 0
        one, other = (self._tree.pose(self.hands[name].carrier) for name in hands)
        return int(np.argmin(np.abs(one.rotation.T @ (other.position - one.position))))

    def carrier_pose(self, hands: Sequence[str], axis: int) -> Pose:
        """Return a frame that moves with one hand, or with two that hold an object together.

        The frame of two hands has its origin between them and its x axis from one to the other.
        Its y axis is near an axis of the first hand. A frame that chose this axis by itself would
        jump when another axis becomes the most orthogonal one, and the object with it.

        Args:
            hands: Names of the hands, one or two.
            axis: Axis of the first hand, from ``cross_axis``.
        """
        poses = [self._tree.pose(self.hands[name].carrier) for name in hands]
        if len(poses) == 1:
            return poses[0]
        one, other = poses
        x = other.position - one.position
        x /= np.linalg.norm(x)
        y = one.rotation[:, axis]
        y = y - (y @ x) * x
        y /= np.linalg.norm(y)
        middle = (one.position + other.position) / 2
        return Pose(middle, np.column_stack((x, y, np.cross(x, y))))

    def touch(self, world: World, contacts: Floats) -> bool:
        """Find the depths of all fingertips in all objects and fixtures.

        Args:
            world: World with the objects.
            contacts: Output: depths, points and normals, as in ``depths``, shape (fingertips,
                things, 7).

        Returns:
            Whether any fingertip touches anything.
        """
        return self._touch(world, self._balls, contacts)

    def near(self, world: World, name: str, distance: float) -> bool:
        """Return whether a fingertip is nearer to an object than a distance, m."""
        contacts = np.zeros((len(self._balls), len(world.solids), 7))
        # A ball whose radius is larger by the distance touches the same objects.
        self._touch(world, self._balls + np.array([0.0, 0.0, 0.0, distance]), contacts)
        return bool((contacts[:, list(world.things).index(name), 0] > 0.0).any())

    def _touch(self, world: World, balls: Floats, contacts: Floats) -> bool:
        solids, placements = world.walls.at(world.solids), self._tree.placements
        if solids is world.solids:
            return depths(solids, placements, self._carriers, balls, contacts)
        each = np.zeros((len(balls), len(solids), 7))
        touching = depths(solids, placements, self._carriers, balls, each)
        # Of a hollow object's walls, each fingertip touches the one in which it is deepest.
        for thing in range(len(world.solids)):
            own = each[:, world.walls.owners == thing]
            deepest = own[:, :, 0].argmax(axis=1)
            contacts[:, thing] = own[np.arange(len(own)), deepest]
        return touching

    def contact(
        self, index: int, thing: KinematicObject, contact: Sequence[float]
    ) -> FingertipContact:
        """Return the contact of a fingertip with an object.

        Args:
            index: Index of the fingertip among all.
            thing: Object in contact.
            contact: Depth, point and normal, 7 numbers.
        """
        depth, x, y, z, u, v, w = contact
        hand, tip = self._fingertips[index]
        return FingertipContact(hand, tip, thing, depth, (x, y, z), (u, v, w))


def _ball(link: UrdfLink) -> tuple[Floats, float]:
    """Return centre and radius of the ball that stands for a fingertip's shape."""
    for shape, pose in solid_shapes(link.collisions):
        # The first shape of the link stands for the fingertip; a longer one becomes its inner ball.
        return pose.position, min(shape.halves)
    return np.zeros(3), 0.0
