"""Forward kinematics and Jacobians of a robot; the only module that uses Pinocchio."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pinocchio

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.forward import (
    JOINT,
    bend_point,
    move_point,
    place_joints,
    place_link,
    place_links,
    place_point,
    place_points,
    rotation_of,
    turn_link,
)
from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UNLIMITED, UrdfError, UrdfInertial, UrdfModel
from cbdsl.robot.urdf_reader import read_urdf

Vector = tuple[float, float, float]
Answer = TypeVar("Answer")


class Frame(NamedTuple):
    """Placement of a link in the world frame.

    Attributes:
        position: Origin, m, shape (3,).
        rotation: Rotation matrix: columns are the link's axes in the world frame, shape (3, 3).
    """

    position: Floats
    rotation: Floats


class Point(NamedTuple):
    """Point of a link, and its Jacobian.

    Attributes:
        position: Position, world frame, m, shape (3,).
        jacobian: Linear above angular velocity, world axes, per joint velocity, shape (6, n).
    """

    position: Floats
    jacobian: Floats


class Link(NamedTuple):
    """Link and the joints that move it.

    Attributes:
        frame: Number of the frame that carries the link; 0 for the base.
        position: Position of the link's origin in that frame, m, shape (3,).
        rotation: Axes of the link in that frame, as columns, shape (3, 3).
        support: Joints that move the link, from the root outwards, shape (k,).
    """

    frame: int
    position: Floats
    rotation: Floats
    support: Integers

    def point(self, offset: Sequence[float]) -> Floats:
        """Return the position in that frame of a point of the link, m, shape (3,)."""
        return np.asarray(self.position + self.rotation.dot(np.array(offset)))


class Kinematics:
    """Placements and Jacobians of links as functions of the actuated joints.

    Passive joints move with the actuated ones they follow, so every Jacobian has one column per
    actuated joint (Eq 3.11-3.12 and their derivatives). Joints are placed on demand, once a
    posture, and only if they move a requested link. A link that carries a camera with a correction
    has the corrected placement instead of the model's.

    Attributes:
        joints: Actuated joints in order.
        positions: Positions of the actuated joints, rad or m, shape (n,); ``update`` overwrites
            them.
        lower: Lower joint limits, rad or m, shape (n,); minus infinity where there is none.
        upper: Upper joint limits, rad or m, shape (n,); infinity where there is none.
        speed: Largest speed of each joint by the model, rad/s or m/s, shape (n,); infinity where
            there is none.
        slides: True for joints with a position in m, shape (n,).
        endless: True for joints that turn without limits, shape (n,).
        circular: True for endless joints whose whole turns do not count, shape (n,).
        tree: Joints of the model, as ``place_joints`` takes them, shape (j,).
        frames, axes: Joint frames and axes in the newest posture, as ``place_joints`` writes them.

    Raises:
        UrdfError: Pinocchio cannot read the model.
    """

    def __init__(self, robot: RobotDocument, urdf: Path) -> None:
        try:
            model = pinocchio.buildModelFromUrdf(str(urdf))
        except ValueError as error:
            raise UrdfError(f"Pinocchio cannot read the model: {error}") from None
        self._urdf, self.joints = urdf, Joints(robot)
        numbers = [model.getJointId(name) for name in self.joints.names]
        own = [model.joints[number].idx_q for number in numbers]
        circle = np.array([model.joints[number].nq > 1 for number in numbers], dtype=bool)
        lower, upper = model.lowerPositionLimit[own], model.upperPositionLimit[own]
        self.lower: Floats = np.where(circle | (lower <= -UNLIMITED), -np.inf, lower)
        self.upper: Floats = np.where(circle | (upper >= UNLIMITED), np.inf, upper)
        fastest = model.velocityLimit[[model.joints[number].idx_v for number in numbers]]
        self.speed: Floats = np.where(fastest > 0.0, fastest, np.inf)
        self._model, self.positions = model, np.zeros(len(self.joints))
        self._still = self._resting()
        self.tree = _tree(model, self.joints, self._still)
        slides = self.tree["slides"][np.array(numbers, dtype=np.int64) - 1]
        self.slides: Booleans = slides
        self.endless: Booleans = np.isinf(self.lower) & np.isinf(self.upper) & ~slides
        self.circular: Booleans = self.endless & ~self.joints.counted
        self.frames = np.zeros((len(self.tree) + 1, 12))
        self.frames[0, [0, 4, 8]] = 1.0
        self.axes = np.zeros((len(self.tree), 3))
        # The same in another posture, see ``posed``.
        self._other = self.positions.copy(), self.frames.copy(), self.axes.copy()
        self._other_posture: Floats | None = None
        self._links: dict[str, Link] = {}
        self._corrections = {
            camera.link: camera.correction
            for camera in robot.cameras.values()
            if camera.correction is not None
        }
        self._origins: dict[tuple[tuple[str, ...], ...], tuple[Integers, Floats]] = {}
        self._together: dict[tuple[str, ...], tuple[Integers, Floats, Floats]] = {}
        self._needed: Integers = np.zeros(0, dtype=np.int64)
        # Counts of joints placed in the newest and in the other posture; -1 for a new posture.
        self._placed = self._other_placed = -1
        self._weighing: tuple[Any, list[Any]] | None = None
        self.update(np.minimum(np.maximum(0.0, self.lower), self.upper))

    def _resting(self) -> Floats:
        """Return the model's configuration where all actuated joints are at 0.

        Passive joints are at their offsets, and joints without a drive at their rest positions.
        """
        still: Floats = pinocchio.neutral(self._model)
        joints = self.joints
        others = set(self._model.names[1:]) - joints.index.keys()
        rests = self.model.rests if others else {}
        for name in (*joints.passive, *others & rests.keys()):
            joint = self._model.joints[self._model.getJointId(name)]
            offset = joints.offsets[joints.index[name]] if name in joints.index else rests[name]
            _set_position(still, joint, float(offset))
        return still

    def update(self, positions: Floats) -> None:
        """Set the actuated joint positions, rad, shape (n,)."""
        self.positions[:], self._placed = positions, -1

    def posed(self, posture: Floats, ask: Callable[[], Answer]) -> Answer:
        """Evaluate a function in another posture.

        Args:
            posture: Joint positions, rad, shape (n,); the same array places joints only once.
            ask: Function to evaluate.
        """
        newest = self.positions, self.frames, self.axes, self._placed
        if self._other_posture is not posture:
            self._other[0][:], self._other_posture, self._other_placed = posture, posture, -1
        self.positions, self.frames, self.axes = self._other
        self._placed = self._other_placed
        try:
            return ask()
        finally:
            self._other_placed = self._placed
            self.positions, self.frames, self.axes, self._placed = newest

    def place(self) -> None:
        """Place the joints in the newest posture, unless that is done."""
        if self._placed != len(self._needed):
            place_joints(self.positions, self._needed, self.tree, self.frames, self.axes)
            self._placed = len(self._needed)

    def link(self, name: str) -> Link:
        """Return a link, whose frame is up to date after ``place``.

        Raises:
            KeyError: There is no link of this name.
        """
        link = self._links.get(name)
        if link is None:
            link = self._links[name] = self._find(name)
        self.place()
        return link

    def frame(self, link: str) -> Frame:
        """Return the current placement of a link, which later updates do not change."""
        here, placed = self.link(link), Frame(np.empty(3), np.empty((3, 3)))
        place_link(self.frames[here.frame], here.position, here.rotation, *placed)
        return placed

    def placed(self, links: tuple[str, ...]) -> list[Frame]:
        """Return the placements of several links; see ``frame``."""
        known = self._together.get(links)
        if known is None:
            each = [self.link(name) for name in links]
            numbers = np.array([link.frame for link in each], dtype=np.int64)
            origins, axes = [e.position for e in each], [e.rotation for e in each]
            known = numbers, np.array(origins), np.array(axes)
            self._together[links] = known
        self.place()
        positions, rotations = np.empty((len(links), 3)), np.empty((len(links), 3, 3))
        place_links(self.frames, *known, positions, rotations)
        return list(map(Frame, positions, rotations))

    def direction(self, link: str, vector: Floats) -> Floats:
        """Return a vector (3,) in a link's axes, expressed in the world frame."""
        turned: Floats = self.frame(link).rotation.dot(vector)
        return turned

    def jacobian(self, link: str) -> Floats:
        """Return the Jacobian of a link, linear above angular, world axes, shape (6, n)."""
        return self.point(link, (0.0, 0.0, 0.0)).jacobian

    def turning(self, link: str) -> Floats:
        """Return the angular velocity of a link, world axes, per joint velocity, shape (3, n)."""
        return self.jacobian(link)[3:]

    def own_turning(self, link: str) -> Floats:
        """Return the angular velocity of a link, its own axes, per joint velocity, shape (3, n)."""
        here, turning = self.link(link), np.zeros((3, len(self.lower)))
        frame = self.frames[here.frame]
        turn_link(frame, here.rotation, here.support, self.tree, self.axes, turning)
        return turning

    def point(self, link: str, offset: Vector) -> Point:
        """Return a point of a link, at an offset, m, from its origin in its own axes."""
        here = self.link(link)
        position, jacobian = np.empty(3), np.zeros((6, len(self.lower)))
        own = here.position + here.rotation.dot(np.array(offset))
        place_point(self.frames[here.frame], own, position)
        move_point(position, here.support, self.tree, self.frames, self.axes, jacobian)
        return Point(position, jacobian)

    def curvature(self, link: str, point: Floats, rows: int) -> Floats:
        """Return the derivative of the Jacobian of a link's point by the joint positions.

        Args:
            link: Link that the point is fixed to.
            point: Point, world frame, m, shape (3,).
            rows: Number of rows: 6, or 3 for the linear velocity alone.

        Returns:
            Derivative, shape (rows, n, n), linear above angular velocity. Entry (k, i, j) is the
            change
            of the Jacobian's entry (k, i) per joint j.
        """
        support, joints = self.link(link).support, len(self.lower)
        curvature = np.zeros((rows, joints, joints))
        bend_point(point, support, self.tree, self.frames, self.axes, curvature)
        return curvature

    def weight(self) -> Floats:
        """Return the torques that bear the links' own weight in this posture, N m, shape (n,).

        They follow from the masses of the model; the mass of a held object is unknown.
        """
        if self._weighing is None:
            numbers = [self._model.getJointId(name) for name in self.joints.all]
            self._weighing = self._model.createData(), [self._model.joints[n] for n in numbers]
        data, moving = self._weighing
        posture = self._still.copy()
        for joint, position in zip(
            moving, self.joints.expand(self.positions).tolist(), strict=True
        ):
            _set_position(posture, joint, position)
        torques = pinocchio.computeGeneralizedGravity(self._model, data, posture)
        own = [self._model.joints[self._model.getJointId(n)].idx_v for n in self.joints.names]
        weight: Floats = torques[own]
        return weight

    def inertial(self, link: str) -> UrdfInertial | None:
        """Return the mass of a link without carried links, ``None`` if the model has none."""
        return self.model.bodies[link].inertial

    @cached_property
    def model(self) -> UrdfModel:
        """URDF model; Pinocchio merges links with fixed joints."""
        return read_urdf(self._urdf)

    def moving(self, link: str) -> frozenset[str]:
        """Return names of the model's joints that move a link, including passive ones."""
        return frozenset(self._model.names[number] for number in self._support(link))

    def above(self, joint: str) -> frozenset[str]:
        """Return names of the model's joints that move a joint, and the joint's own name."""
        supports = self._model.supports[self._model.getJointId(joint)]
        return frozenset(self._model.names[number] for number in list(supports)[1:])

    def origins(self, joints: tuple[str, ...], links: tuple[str, ...]) -> Floats:
        """Return origins of the named joints and links in the world frame, m, shape (k, 3)."""
        known = self._origins.get((joints, links))
        if known is None:
            known = self._origins[joints, links] = self._find_origins(joints, links)
        self.place()
        numbers, offsets = known
        origins = np.empty((len(numbers), 3))
        place_points(self.frames, numbers, offsets, origins)
        return origins

    def _find_origins(
        self, joints: tuple[str, ...], links: tuple[str, ...]
    ) -> tuple[Integers, Floats]:
        """Return the frame numbers of joints and links, and their origins in these frames."""
        numbers = [self._model.getJointId(name) for name in joints]
        for number in numbers:
            self._need(list(self._model.supports[number])[1:])
        placed = [self.link(name) for name in links]
        offsets = [*np.zeros((len(joints), 3)), *(link.position for link in placed)]
        frames = np.array([*numbers, *(link.frame for link in placed)], dtype=np.int64)
        return frames, np.array(offsets).reshape(len(offsets), 3)

    def _need(self, numbers: Sequence[int]) -> None:
        """Add joints to the set that ``place`` updates."""
        self._needed = np.union1d(self._needed, np.array(numbers, dtype=np.int64) - 1)

    def _find(self, name: str) -> Link:
        numbers, frame = self._support(name), self._model.frames[self._frame(name)]
        self._need(numbers)
        support = np.array([n - 1 for n in numbers if self.tree["ratio"][n - 1]], dtype=np.int64)
        placement = frame.placement
        origin, axes = placement.translation.copy(), placement.rotation.copy()
        correction = self._corrections.get(name)
        if correction is not None:
            origin += axes.dot(np.array(correction.position))
            axes = axes.dot(rotation_of(np.array(correction.rotation)))
        return Link(frame.parentJoint, origin, axes, support)

    def _support(self, link: str) -> list[int]:
        """Return numbers of the joints that move a link, from the root outwards."""
        # The first entry is the world; all others are joints.
        joint = self._model.frames[self._frame(link)].parentJoint
        return list(self._model.supports[joint])[1:]

    def _frame(self, link: str) -> int:
        # Frames of joints may have the same names as frames of links.
        index: int = self._model.getFrameId(link, pinocchio.FrameType.BODY)
        if index >= self._model.nframes:
            raise KeyError(link)
        return index


def _set_position(configuration: Floats, joint: Any, position: float) -> None:
    """Set the position, rad or m, of a Pinocchio joint in a configuration of its model."""
    place, size = joint.idx_q, joint.nq
    # An endless joint has two coordinates: a point on the unit circle.
    turn = (position,) if size == 1 else (math.cos(position), math.sin(position))
    configuration[place : place + size] = turn


def _tree(model: Any, joints: Joints, still: Floats) -> Any:
    """Return the moving joints of a Pinocchio model.

    The position of a joint in the configuration ``still`` is part of its placement. Offsets of
    passive joints and joints without a drive therefore need no computation.
    """
    tree = np.zeros(model.njoints - 1, JOINT)
    at_rest = model.createData()
    pinocchio.forwardKinematics(model, at_rest, still)
    placements = at_rest.liMi
    for number in range(1, model.njoints):
        joint, row = model.joints[number], tree[number - 1]
        data = joint.createData()
        joint.calc(data, still[joint.idx_q : joint.idx_q + joint.nq])
        placement = placements[number]
        # Pinocchio orders the motion subspace as linear above angular components, in the joint's
        # axes.
        subspace = np.asarray(data.S).ravel()
        row["slides"] = subspace[:3].any()
        row["axis"] = subspace[:3] if row["slides"] else subspace[3:]
        row["parent"] = model.parents[number]
        row["rotation"], row["origin"] = placement.rotation.ravel(), placement.translation
        # A joint without a drive has the ratio 0, and stays where ``still`` places it.
        place = joints.index.get(model.names[number])
        moved = np.zeros(1) if place is None else joints.expansion[place]
        row["column"], row["ratio"] = int(np.argmax(moved != 0.0)), float(moved.sum())
    return tree
