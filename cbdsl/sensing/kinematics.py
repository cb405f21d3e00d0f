"""Forward kinematics and Jacobians of a robot: the only home of Pinocchio."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfError
from cbdsl.sensing.motion import Integers, Vector, component_along, curvature_at, point_at

Floats = NDArray[np.float64]

_ORIGIN = (0.0, 0.0, 0.0)


class Frame(NamedTuple):
    """A link's placement in the world frame.

    Attributes:
        position: m, shape (3,).
        rotation: columns are the link's axes in the world frame, shape (3, 3).
    """

    position: Floats
    rotation: Floats


class Point(NamedTuple):
    """A point of a link, and how it and the link move.

    Attributes:
        position: world frame, m, shape (3,).
        jacobian: linear above angular velocity, world axes, per joint velocity, shape (6, n).
    """

    position: Floats
    jacobian: Floats


class _Limb:
    """The joints that leave the base at one of them, or none for what is fixed to the base.

    Each is a model of its own: only limbs that somebody asks about are moved, and only to postures
    that are new. In many ticks that is the head alone.

    Attributes:
        data: Pinocchio's memory for the posture.
        joints: the limb's joints by their numbers in the robot's model.
        positions: of all actuated joints, of which ``data`` is, rad, shape (n,).
        frames, points: what has been asked for in the posture of ``data``.
        turnings: the same by the joint that carries a link, as every point of such links turns.
        own_turnings: the same by link, in its own axes.
    """

    def __init__(self, model: Any, numbers: Sequence[int]) -> None:
        self._model = pinocchio.Model()
        self._numbers = {0: 0}
        for number in numbers:
            joint, parent = model.joints[number], self._numbers[model.parents[number]]
            placement, name = model.jointPlacements[number], model.names[number]
            self._numbers[number] = self._model.addJoint(parent, joint, placement, name)
        self.joints = {number: model.joints[number] for number in numbers}
        for frame in model.frames:
            if frame.type == pinocchio.FrameType.BODY and frame.parentJoint in self._numbers:
                joint = self._numbers[frame.parentJoint]
                own = pinocchio.Frame(frame.name, joint, 0, frame.placement, frame.type)
                self._model.addFrame(own)
        self.data = self._model.createData()
        # Pinocchio numbers the joints of a model limb after limb.
        first = min((joint.idx_q for joint in self.joints.values()), default=0)
        self._own = slice(first, first + self._model.nq)
        self._posture: bytes | None = None
        self.positions: Floats | None = None
        self.frames: dict[str, Frame] = {}
        self.points: dict[tuple[str, Vector], Point] = {}
        self.turnings: dict[int, Floats] = {}
        self.own_turnings: dict[str, Floats] = {}

    def move(self, positions: Floats, turned: Floats) -> None:
        """Let ``data`` have the newest posture, given the coordinates of all the model's joints."""
        self.positions = positions
        own = turned[self._own]
        posture = own.tobytes()
        if posture == self._posture:
            return
        self._posture = posture
        self.frames.clear()
        self.points.clear()
        self.turnings.clear()
        self.own_turnings.clear()
        pinocchio.computeJointJacobians(self._model, self.data, own)
        pinocchio.updateFramePlacements(self._model, self.data)

    def placement(self, link: str) -> Any:
        """Pinocchio's memory for the placement of a link."""
        return self.data.oMf[self._model.getFrameId(link, pinocchio.FrameType.BODY)]

    def origin(self, number: int) -> Floats:
        """Pinocchio's memory for the origin of a joint, m, shape (3,)."""
        found: Floats = self.data.oMi[self._numbers[number]].translation
        return found

    def velocity(self, number: int) -> int:
        """Which column of the limb's own Jacobians is a joint's."""
        found: int = self._model.joints[self._numbers[number]].idx_v
        return found


class _Link(NamedTuple):
    """A link, and the k joints that move it.

    Attributes:
        limb: what it is part of.
        joint: number of the joint that carries it, in the robot's model; 0 for none.
        position: its origin in the world frame, m, shape (3,), and
        rotation: its axes as columns, shape (3, 3): memory that Pinocchio updates.
        support: what ``point_at`` wants to know of them, the axes in Pinocchio's memory as well.
    """

    limb: _Limb
    joint: int
    position: Floats
    rotation: Floats
    support: tuple[Floats, Integers, Integers, Floats]


_Origins = list[tuple[_Limb, Floats]]


class Kinematics:
    """Placements and Jacobians of links as functions of the actuated joints.

    Passive joints move with the actuated ones they follow, so every Jacobian has one column per
    actuated joint (Eq 3.11-3.12 and their derivatives).

    Attributes:
        joints: the order of the actuated joints.
        lower: lower joint limits, rad, shape (n,).
        upper: upper joint limits, rad, shape (n,).

    Raises:
        UrdfError: the model is none that Pinocchio reads.
    """

    def __init__(self, robot: RobotDocument, urdf: Path) -> None:
        # Pinocchio's own mimic joints break its dynamics algorithms, so couplings are applied here.
        try:
            self._model = pinocchio.buildModelFromUrdf(str(urdf))
        except ValueError as error:
            raise UrdfError(f"Pinocchio cannot read the model: {error}") from None
        self.joints = Joints(robot)
        moved = [self._model.joints[self._model.getJointId(name)] for name in self.joints.all]
        columns = [joint.idx_v for joint in moved]
        own = [joint.idx_q for joint in moved][: len(self.joints)]
        #: Velocities of the model's joints per velocity of the actuated ones, shape (nv, n).
        self._expansion: Floats = np.zeros((self._model.nv, len(self.joints)))
        self._expansion[columns] = self.joints.expansion
        self.lower: Floats = self._model.lowerPositionLimit[own]
        self.upper: Floats = self._model.upperPositionLimit[own]
        self._has_wheels = self._model.nq != self._model.nv
        self._limbs = self._parted()
        self._links: dict[str, _Link] = {}
        #: Those whose limbs have the newest posture.
        self._now: dict[str, _Link] = {}
        self._origins: dict[tuple[tuple[str, ...], tuple[str, ...]], _Origins] = {}
        self._turned: Floats | None = None
        self.update(np.minimum(np.maximum(0.0, self.lower), self.upper))

    def update(self, positions: Floats) -> None:
        """Set the actuated joint positions, rad, shape (n,)."""
        self._positions, self._turned = positions.copy(), None
        self._now.clear()

    def _move(self, limb: _Limb) -> None:
        """Let a limb have the newest posture."""
        if self._turned is None:
            self._turned = self._expansion.dot(self._positions)
            if self._has_wheels:
                # A joint without limits has two coordinates and one velocity.
                still = pinocchio.neutral(self._model)
                self._turned = pinocchio.integrate(self._model, still, self._turned)
        limb.move(self._positions, self._turned)

    def frame(self, link: str) -> Frame:
        """The placement of a link, which stays as it is now."""
        here = self._now.get(link) or self._link(link)
        found = here.limb.frames.get(link)
        if found is None:
            found = Frame(here.position.copy(), here.rotation.copy())
            here.limb.frames[link] = found
        return found

    def direction(self, link: str, vector: Floats) -> Floats:
        """A vector (3,) of a link's own axes, in the world's."""
        found: Floats = self._link(link).rotation.dot(vector)
        return found

    def component(self, link: str, axis: Floats, vector: Floats) -> float:
        """The component of a vector (3,) along an axis (3,) of a link's own, in its unit."""
        here = self._now.get(link) or self._link(link)
        found: float = component_along(here.rotation, axis, vector)
        return found

    def jacobian(self, link: str) -> Floats:
        """Linear and angular velocity of a link, world axes, per joint velocity, shape (6, n)."""
        return self.point(link, _ORIGIN).jacobian

    def turning(self, link: str) -> Floats:
        """Angular velocity of a link, world axes, per joint velocity, shape (3, n)."""
        here = self._now.get(link) or self._link(link)
        found = here.limb.turnings.get(here.joint)
        return self.jacobian(link)[3:] if found is None else found

    def own_turning(self, link: str) -> Floats:
        """Angular velocity of a link, its own axes, per joint velocity, shape (3, n)."""
        known = (self._now.get(link) or self._link(link)).limb.own_turnings
        found = known.get(link)
        if found is None:
            found = known[link] = self.frame(link).rotation.T.dot(self.turning(link))
        return found

    def point(self, link: str, offset: Vector) -> Point:
        """A point of a link, ``offset`` from its origin in its own axes, m."""
        limb, joint, position, rotation, support = self._now.get(link) or self._link(link)
        found = limb.points.get((link, offset))
        if found is None:
            found = Point(np.empty(3), np.zeros((6, len(self.lower))))
            x, y, z = offset
            point_at(x, y, z, position, rotation, *support, *found)
            limb.points[link, offset] = found
            limb.turnings[joint] = found.jacobian[3:]
        return found

    def curvature(self, link: str, point: Floats, rows: int) -> Floats:
        """The derivative of the Jacobian of a point of a link by the joints.

        Args:
            link: what the point moves with.
            point: world frame, m, shape (3,).
            rows: 6, or 3 for the linear velocity alone.

        Returns:
            Shape (rows, n, n): entry (k, i, j) is the change of the Jacobian's entry (k, i) per
            joint j, linear above angular velocity.
        """
        joints = len(self.lower)
        found = np.zeros((rows, joints, joints))
        curvature_at(point, *self._link(link).support, found)
        return found

    def moving(self, link: str) -> frozenset[str]:
        """Names of the model's joints that move a link, passive ones too."""
        return frozenset(self._model.names[number] for number in self._support(link))

    def origins(self, joints: tuple[str, ...], links: tuple[str, ...]) -> Floats:
        """Origins of the named joints and links in the world frame, m, shape (k, 3)."""
        found = self._origins.get((joints, links))
        if found is None:
            origins = [self._joint(name) for name in joints]
            origins += [(link.limb, link.position) for link in map(self._link, links)]
            found = self._origins[joints, links] = origins
        for limb, _ in found:
            if limb.positions is not self._positions:
                self._move(limb)
        return np.array([origin for _, origin in found]).reshape(len(found), 3)

    def _joint(self, name: str) -> tuple[_Limb, Floats]:
        """The limb that a joint is part of, and its origin in Pinocchio's memory, shape (3,)."""
        number = self._model.getJointId(name)
        limb = self._limbs[self._model.supports[number][1]]
        return limb, limb.origin(number)

    def _link(self, name: str) -> _Link:
        """A link now."""
        found = self._links.get(name)
        if found is None:
            found = self._links[name] = self._found(name)
        if found.limb.positions is not self._positions:
            self._move(found.limb)
        self._now[name] = found
        return found

    def _found(self, name: str) -> _Link:
        numbers = self._support(name)
        first, last = (numbers[0], numbers[-1]) if numbers else (0, 0)
        limb = self._limbs[first]
        moved = [limb.joints[number].idx_v for number in numbers]
        own = self._expansion[moved]
        rows, columns = np.nonzero(own)
        velocities = np.array([limb.velocity(number) for number in numbers], dtype=np.intp)
        support = limb.data.J, velocities[rows], columns, own[rows, columns]
        placement = limb.placement(name)
        return _Link(limb, last, placement.translation, placement.rotation, support)

    def _parted(self) -> dict[int, _Limb]:
        """The limbs by the numbers of their first joints; 0 for what no joint moves."""
        numbers = range(1, self._model.njoints)
        first = [number for number in numbers if self._model.parents[number] == 0]
        limbs = {number: _Limb(self._model, list(self._model.subtrees[number])) for number in first}
        return {0: _Limb(self._model, ()), **limbs}

    def _support(self, link: str) -> list[int]:
        """Numbers of the joints that move a link, from the root outwards."""
        # Frames of joints may have the same names as frames of links.
        index = self._model.getFrameId(link, pinocchio.FrameType.BODY)
        if index >= self._model.nframes:
            raise KeyError(link)
        # The first entry is the world; every further one is a joint.
        return list(self._model.supports[self._model.frames[index].parentJoint])[1:]
