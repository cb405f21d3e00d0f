"""Forward kinematics and Jacobians of a robot: the only home of Pinocchio."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.motion import Integers, Vector, component_along, curvature_at, point_at
from cbdsl.robot.urdf import UrdfError

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


class _Link(NamedTuple):
    """A link, and the k joints that move it.

    Attributes:
        position: its origin in the world frame, m, shape (3,), and
        rotation: its axes as columns, shape (3, 3): memory that Pinocchio updates.
        support: what ``point_at`` wants to know of them, the axes in Pinocchio's memory as well.
    """

    position: Floats
    rotation: Floats
    support: tuple[Floats, Integers, Integers, Floats]


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
        self._data = self._model.createData()
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
        self._links: dict[str, _Link] = {}
        self._origins: dict[str, Floats] = {}
        self._frames: dict[str, Frame] = {}
        self._points: dict[tuple[str, Vector], Point] = {}
        self._turnings: dict[str, Floats] = {}
        self.update(np.minimum(np.maximum(0.0, self.lower), self.upper))

    def update(self, positions: Floats) -> None:
        """Set the actuated joint positions, rad, shape (n,)."""
        self._positions, self._is_new = positions.copy(), True
        self._frames.clear()
        self._points.clear()
        self._turnings.clear()

    def _move(self) -> None:
        """Let Pinocchio's memory have the newest posture: in many ticks, nobody asks for it."""
        self._is_new = False
        turned = self._expansion.dot(self._positions)
        if self._has_wheels:
            # A joint without limits has two coordinates and one velocity.
            turned = pinocchio.integrate(self._model, pinocchio.neutral(self._model), turned)
        pinocchio.computeJointJacobians(self._model, self._data, turned)
        pinocchio.updateFramePlacements(self._model, self._data)

    def frame(self, link: str) -> Frame:
        """The placement of a link, which stays as it is now."""
        found = self._frames.get(link)
        if found is None:
            here = self._link(link)
            found = self._frames[link] = Frame(here.position.copy(), here.rotation.copy())
        return found

    def direction(self, link: str, vector: Floats) -> Floats:
        """A vector (3,) of a link's own axes, in the world's."""
        found: Floats = self._link(link).rotation.dot(vector)
        return found

    def component(self, link: str, axis: Floats, vector: Floats) -> float:
        """The component of a vector (3,) along an axis (3,) of a link's own, in its unit."""
        found: float = component_along(self._link(link).rotation, axis, vector)
        return found

    def jacobian(self, link: str) -> Floats:
        """Linear and angular velocity of a link, world axes, per joint velocity, shape (6, n)."""
        return self.point(link, _ORIGIN).jacobian

    def turning(self, link: str) -> Floats:
        """Angular velocity of a link, world axes, per joint velocity, shape (3, n)."""
        found = self._turnings.get(link)
        # Every point of a link turns as the link does.
        return self.jacobian(link)[3:] if found is None else found

    def point(self, link: str, offset: Vector) -> Point:
        """A point of a link, ``offset`` from its origin in its own axes, m."""
        found = self._points.get((link, offset))
        if found is None:
            here = self._link(link)
            found = Point(np.empty(3), np.zeros((6, len(self.lower))))
            x, y, z = offset
            point_at(x, y, z, here.position, here.rotation, *here.support, *found)
            self._points[link, offset] = found
            self._turnings[link] = found.jacobian[3:]
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
        joint = self._model.frames[self._index(link)].parentJoint
        return frozenset(self._model.names[i] for i in list(self._model.supports[joint])[1:])

    def origins(self, joints: tuple[str, ...], links: tuple[str, ...]) -> Floats:
        """Origins of the named joints and links in the world frame, m, shape (k, 3)."""
        found = [self._joint(name) for name in joints]
        found += [self._link(name).position for name in links]
        return np.array(found).reshape(len(found), 3)

    def _joint(self, name: str) -> Floats:
        """The origin of a joint now, shape (3,): memory that Pinocchio updates."""
        if self._is_new:
            self._move()
        found = self._origins.get(name)
        if found is None:
            index = self._model.getJointId(name)
            found = self._origins[name] = self._data.oMi[index].translation
        return found

    def _link(self, name: str) -> _Link:
        """A link now."""
        if self._is_new:
            self._move()
        found = self._links.get(name)
        if found is None:
            found = self._links[name] = self._found(name)
        return found

    def _found(self, name: str) -> _Link:
        index = self._index(name)
        placement, joint = self._data.oMf[index], self._model.frames[index].parentJoint
        # The first entry is the world; every further one is a joint, from the root outwards.
        joints = [self._model.joints[i] for i in list(self._model.supports[joint])[1:]]
        velocities = np.array([each.idx_v for each in joints], dtype=np.intp)
        own = self._expansion[velocities]
        rows, columns = np.nonzero(own)
        support = self._data.J, velocities[rows], columns, own[rows, columns]
        return _Link(placement.translation, placement.rotation, support)

    def _index(self, link: str) -> int:
        # Frames of joints may have the same names as frames of links.
        index: int = self._model.getFrameId(link, pinocchio.FrameType.BODY)
        if index >= self._model.nframes:
            raise KeyError(link)
        return index
