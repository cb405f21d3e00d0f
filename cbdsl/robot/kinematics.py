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


@dataclass(frozen=True)
class Frame:
    """A link's placement in the world frame.

    Attributes:
        position: m, shape (3,).
        rotation: columns are the link's axes in the world frame, shape (3, 3).
    """

    position: Floats
    rotation: Floats


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
        self._frames: dict[str, Frame] = {}
        self._jacobians: dict[str, Floats] = {}

    def update(self, positions: Floats) -> None:
        """Set the actuated joint positions, rad, shape (n,)."""
        turned = self._expansion @ positions
        if self._model.nq != self._model.nv:
            # A joint without limits has two coordinates and one velocity.
            turned = pinocchio.integrate(self._model, pinocchio.neutral(self._model), turned)
        pinocchio.computeJointJacobians(self._model, self._data, turned)
        pinocchio.updateFramePlacements(self._model, self._data)
        self._frames.clear()
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
            full = pinocchio.getFrameJacobian(
                self._model,
                self._data,
                self._index(link),
                pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED,
            )
            found = self._jacobians[link] = full.dot(self._expansion)
        return found

    def joint_positions(self, joints: tuple[str, ...]) -> Floats:
        """Origins of the named joints in the world frame, m, shape (len(joints), 3)."""
        model, data = self._model, self._data
        return np.array([data.oMi[model.getJointId(name)].translation for name in joints])

    def _index(self, link: str) -> int:
        index = self._indices.get(link)
        if index is None:
            # Frames of joints may have the same names as frames of links.
            index = self._model.getFrameId(link, pinocchio.FrameType.BODY)
            if index >= self._model.nframes:
                raise KeyError(link)
            self._indices[link] = index
        return index
