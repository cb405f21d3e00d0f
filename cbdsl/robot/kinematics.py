"""Forward kinematics and Jacobians of a robot: the only home of Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints

Floats = NDArray[np.float64]


#: The Levi-Civita symbol: ``_CROSS.dot(u)`` is the matrix that takes the product u x v from v.
_CROSS: Floats = np.array(
    [
        [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
    ]
)


@dataclass(frozen=True)
class Frame:
    """A link's placement in the world frame.

    Attributes:
        position: m, shape (3,).
        rotation: columns are the link's axes in the world frame, shape (3, 3).
    """

    position: Floats
    rotation: Floats


class _Support:
    """The k joints that move a link.

    Attributes:
        velocities: their indices among the model's velocities, from the root outwards, shape (k,).
        expansion: their velocities per velocity of the actuated joints, shape (k, n).
        columns: indices of these joints among the actuated ones, where they are all actuated
            themselves, shape (k,); otherwise ``None``.
        in_order: whether joint i is not beyond joint j, shape (k, k).
    """

    def __init__(self, velocities: NDArray[np.intp], expansion: Floats) -> None:
        self.velocities = velocities
        self.expansion = expansion
        columns = np.argmax(expansion, axis=1)
        direct = np.array_equal(expansion, np.eye(expansion.shape[1])[columns])
        self.columns = columns if direct else None
        self.in_order = np.triu(np.ones((len(velocities), len(velocities)), dtype=bool))


class Kinematics:
    """Placements and Jacobians of links as functions of the actuated joints.

    Passive joints move with the actuated ones they follow, so every Jacobian has one column per
    actuated joint (Eq 3.11-3.12 and their derivatives).

    Attributes:
        joints: the order of the actuated joints.
        lower: lower joint limits, rad, shape (n,).
        upper: upper joint limits, rad, shape (n,).
    """

    def __init__(self, robot: RobotDocument, urdf: Path) -> None:
        # Pinocchio's own mimic joints break its dynamics algorithms, so couplings are applied here.
        self._model = pinocchio.buildModelFromUrdf(str(urdf))
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
        self._indices: dict[str, int] = {}
        self._supports: dict[str, _Support] = {}
        self._frames: dict[str, Frame] = {}
        self._full: dict[str, Floats] = {}
        self._jacobians: dict[str, Floats] = {}
        self.update(np.minimum(np.maximum(0.0, self.lower), self.upper))

    def update(self, positions: Floats) -> None:
        """Set the actuated joint positions, rad, shape (n,)."""
        turned = self._expansion.dot(positions)
        if self._model.nq != self._model.nv:
            # A joint without limits has two coordinates and one velocity.
            turned = pinocchio.integrate(self._model, pinocchio.neutral(self._model), turned)
        pinocchio.computeJointJacobians(self._model, self._data, turned)
        pinocchio.updateFramePlacements(self._model, self._data)
        self._frames.clear()
        self._full.clear()
        self._jacobians.clear()

    def frame(self, link: str) -> Frame:
        """The placement of a link."""
        found = self._frames.get(link)
        if found is None:
            placement = self._data.oMf[self._index(link)]
            found = Frame(placement.translation.copy(), placement.rotation.copy())
            self._frames[link] = found
        return found

    def jacobian(self, link: str) -> Floats:
        """Linear and angular velocity of a link, world axes, per joint velocity, shape (6, n)."""
        found = self._jacobians.get(link)
        if found is None:
            found = self._jacobians[link] = self._full_jacobian(link).dot(self._expansion)
        return found

    def curvature(self, link: str, lever: Floats) -> Floats:
        """The derivative of a link's Jacobian by the joints.

        A joint turns the axes and levers of the joints beyond it, and moves the point as it turns
        those before it: of joints i before j, the column of either changes by the other as
        omega_i x v_j; their axes change as omega_i x omega_j, by joint i alone.

        Args:
            link: the link.
            lever: from the link's origin to the point that moves, world axes, m, shape (3,).

        Returns:
            Shape (6, n, n): entry (k, i, j) is the change of the Jacobian's entry (k, i) per
            joint j, linear above angular velocity.
        """
        support = self._support(link)
        full = self._full_jacobian(link)[:, support.velocities]
        angular = full[3:]  # (3, k)
        axes = _CROSS.dot(angular).transpose(0, 2, 1)  # (3, k, 3)
        linear = full[:3] + axes.dot(lever)
        moved = np.matmul(axes, linear)
        turned = np.matmul(axes, angular)
        own = np.concatenate(
            (
                np.where(support.in_order, moved, moved.transpose(0, 2, 1)),
                np.where(support.in_order, 0.0, turned.transpose(0, 2, 1)),
            )
        )
        if support.columns is None:
            return np.asarray(np.matmul(support.expansion.T, np.matmul(own, support.expansion)))
        joints = support.expansion.shape[1]
        curvature: Floats = np.zeros((6, joints, joints))
        curvature[:, support.columns[:, None], support.columns] = own
        return curvature

    def moving(self, link: str) -> frozenset[str]:
        """Names of the model's joints that move a link, passive ones too."""
        joint = self._model.frames[self._index(link)].parentJoint
        return frozenset(self._model.names[i] for i in list(self._model.supports[joint])[1:])

    def joint_positions(self, joints: tuple[str, ...]) -> Floats:
        """Origins of the named joints in the world frame, m, shape (len(joints), 3)."""
        model, data = self._model, self._data
        return np.array([data.oMi[model.getJointId(name)].translation for name in joints])

    def _full_jacobian(self, link: str) -> Floats:
        """By all velocities of the model, passive joints too, shape (6, nv)."""
        found = self._full.get(link)
        if found is None:
            found = self._full[link] = pinocchio.getFrameJacobian(
                self._model,
                self._data,
                self._index(link),
                pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED,
            )
        return found

    def _support(self, link: str) -> _Support:
        found = self._supports.get(link)
        if found is None:
            joint = self._model.frames[self._index(link)].parentJoint
            # The first entry is the world; every further one is a joint, from the root outwards.
            joints = [self._model.joints[i] for i in list(self._model.supports[joint])[1:]]
            velocities = np.array([j.idx_v for j in joints], dtype=np.intp)
            found = self._supports[link] = _Support(velocities, self._expansion[velocities])
        return found

    def _index(self, link: str) -> int:
        index = self._indices.get(link)
        if index is None:
            # Frames of joints may have the same names as frames of links.
            index = self._model.getFrameId(link, pinocchio.FrameType.BODY)
            if index >= self._model.nframes:
                raise KeyError(link)
            self._indices[link] = index
        return index
