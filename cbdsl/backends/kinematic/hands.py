"""The robot's hands as far as they touch: fingertips, and what carries them."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, takewhile
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.bullet.pose import Pose
from cbdsl.backends.kinematic.links import Links, Solid
from cbdsl.backends.kinematic.solids import clearances
from cbdsl.backends.kinematic.thing import Thing
from cbdsl.backends.kinematic.world import World
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.kinematics import Kinematics
from cbdsl.robot.urdf import UrdfModel

Floats = NDArray[np.float64]
Columns = NDArray[np.intp]

# Of links for which the robot file names no surface, as of PyBullet's bodies.
_FRICTION = 0.5


class Fingertip(NamedTuple):
    """A ball at the end of a finger.

    Attributes:
        cell: index of its load cell among all.
        link: that carries it.
        centre: in the link's frame, m, shape (3,).
        radius: m.
        friction: coefficient.
        joints: indices of the hand's joints that move it.
    """

    cell: int
    link: str
    centre: Floats
    radius: float
    friction: float
    joints: Columns


@dataclass(frozen=True)
class Hand:
    """Fingertips that belong together.

    Attributes:
        name: as the robot file has it.
        carrier: link that carries all of its fingers.
        fingertips: in the order of their load cells.
        reach: no fingertip gets further from the carrier's origin than this, m.
    """

    name: str
    carrier: str
    fingertips: tuple[Fingertip, ...]
    reach: float


@dataclass(frozen=True)
class Contact:
    """A fingertip pressed into something.

    Attributes:
        hand: name of the hand.
        fingertip: that touches.
        thing: that is touched.
        depth: how far the undeformed fingertip would be inside, m.
        point: where, in the world frame, m, shape (3,).
        normal: unit vector into the thing, shape (3,).
    """

    hand: str
    fingertip: Fingertip
    thing: Thing
    depth: float
    point: Floats
    normal: Floats


class Hands:
    """All hands with load cells.

    Attributes:
        cells: the load cells, as (hand, finger), in the robot file's order.
        hands: by name.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, model: UrdfModel, links: Links
    ) -> None:
        self._robot, self._model, self._links = robot, model, links
        self._kinematics = kinematics
        self.cells = tuple(
            (hand, finger) for hand, found in robot.load_cells.items() for finger in found
        )
        self.hands = {name: self._hand(name) for name in robot.load_cells}

    def _hand(self, name: str) -> Hand:
        fingertips = tuple(
            self._fingertip(self.cells.index((name, finger)), name, cell.link)
            for finger, cell in self._robot.load_cells[name].items()
        )
        carrier = self._carrier(fingertips[0].link)
        reach = max(self._reach(carrier, tip) for tip in fingertips)
        return Hand(name, carrier, fingertips, reach)

    def _fingertip(self, index: int, hand: str, link: str) -> Fingertip:
        moving = self._kinematics.moving(link)
        followed = {self._robot.couplings[j].follows for j in moving if j in self._robot.couplings}
        own = [j for j in self._robot.joints(hand) if j in moving | followed]
        solid = next(iter(self._links.solids.get(link, ())), None)
        centre, radius = _ball(solid)
        joints = self._kinematics.joints.pick(own)
        return Fingertip(index, link, centre, radius, self._friction(link), joints)

    def _friction(self, link: str) -> float:
        for surface in self._robot.simulation.surfaces:
            if any(fnmatch.fnmatchcase(link, pattern) for pattern in surface.links):
                return surface.friction
        return _FRICTION

    def _carrier(self, link: str) -> str:
        """The link at the tip of the arm that moves a fingertip; without an arm, the base."""
        moving = self._kinematics.moving(link)
        for effector in self._robot.effectors.values():
            if effector.tip is not None and moving.issuperset(effector.joints):
                return effector.tip.link
        return self._robot.base

    def _reach(self, carrier: str, tip: Fingertip) -> float:
        """Length of the chain of joints from the carrier to a fingertip."""
        beyond = self._kinematics.moving(carrier)
        chain = tuple(takewhile(lambda joint: joint not in beyond, self._model.above(tip.link)))
        ends = [self._kinematics.frame(tip.link).position]
        ends += list(self._kinematics.joint_positions(chain)) if chain else []
        ends.append(self._kinematics.frame(carrier).position)
        length = sum(float(np.linalg.norm(b - a)) for a, b in pairwise(ends))
        return length + float(np.linalg.norm(tip.centre)) + tip.radius

    def carrier_pose(self, hands: Sequence[str]) -> Pose:
        """A frame that goes along with one hand, or with two that hold something together.

        That of two hands has its origin between them and its x axis from one to the other.
        """
        frames = [self._kinematics.frame(self.hands[name].carrier) for name in hands]
        if len(frames) == 1:
            return Pose(frames[0].position, frames[0].rotation)
        between = frames[1].position - frames[0].position
        x = between / np.linalg.norm(between)
        # Of the first hand's axes, the one most across the way to the other hand.
        across = int(np.argmin(np.abs(frames[0].rotation.T @ x)))
        y = frames[0].rotation[:, across]
        y = y - (y @ x) * x
        y /= np.linalg.norm(y)
        return Pose(
            (frames[0].position + frames[1].position) / 2, np.column_stack((x, y, np.cross(x, y)))
        )

    def contacts(self, world: World) -> list[Contact]:
        """Where fingertips are pressed into things or fixtures."""
        if not world.things or not self.hands:
            return []
        centres = np.array(
            [self._kinematics.frame(h.carrier).position for h in self.hands.values()]
        )
        near = clearances(world.solids, centres)[:, :, 0].min(axis=1)
        return [
            contact
            for hand, distance in zip(self.hands.values(), near.tolist(), strict=True)
            if distance < hand.reach
            for contact in self._touches(hand, world)
        ]

    def _touches(self, hand: Hand, world: World) -> Iterator[Contact]:
        frames = [self._kinematics.frame(tip.link) for tip in hand.fingertips]
        centres = np.array(
            [
                frame.position + frame.rotation.dot(tip.centre)
                for frame, tip in zip(frames, hand.fingertips, strict=True)
            ]
        )
        radii = np.array([tip.radius for tip in hand.fingertips])
        found = clearances(world.solids, centres)
        depths = radii[:, None] - found[:, :, 0]
        things = list(world.things.values())
        for tip, thing in zip(*np.nonzero(depths > 0.0), strict=True):
            normal = -found[tip, thing, 1:]
            point = centres[tip] + hand.fingertips[tip].radius * normal
            depth = float(depths[tip, thing])
            yield Contact(hand.name, hand.fingertips[tip], things[thing], depth, point, normal)


def _ball(solid: Solid | None) -> tuple[Floats, float]:
    """Centre and radius of the ball that stands for a fingertip's shape."""
    if solid is None:
        return np.zeros(3), 0.0
    return solid.pose.position, min(solid.shape.halves)
