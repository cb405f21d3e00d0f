"""The posture in which episodes begin, and the links that overlap there."""

from __future__ import annotations

from typing import Any

import mujoco as mj
import numpy as np

from cbdsl.backends.mujoco.robot_spec import compile_spec
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel

# Links that are this far inside each other cannot be so in the world, m.
_OVERLAP = 0.001


class FirstPosture:
    """A robot at rest in the posture in which episodes begin.

    Args:
        spec: of the robot; stays as it is.
        robot: names joints and postures.
        model: its URDF.

    Attributes:
        compiled: MuJoCo's model.
        data: its state.

    Raises:
        BackendError: the robot cannot be simulated.
    """

    def __init__(self, spec: Any, robot: RobotDocument, model: UrdfModel) -> None:
        joints = Joints(robot)
        self.compiled = compile_spec(spec.copy(), model)
        self.data = mj.MjData(self.compiled)
        start = np.zeros(len(joints.names))
        for name, effector in robot.effectors.items():
            if effector.start is not None:
                start[joints.of(name)] = effector.postures[effector.start]
        rows = [int(self.compiled.joint(name).qposadr[0]) for name in joints.all]
        self.data.qpos[rows] = joints.expand(start)
        mj.mj_forward(self.compiled, self.data)

    def overlaps(self) -> list[tuple[str, str]]:
        """Pairs of bodies that are inside each other.

        Hulls are larger than meshes, and many public models have links that overlap besides.
        Nothing can push these apart, so that a robot would be thrown about by trying.
        """
        deep = self.data.contact.geom[self.data.contact.dist < -_OVERLAP]
        bodies = np.unique(np.sort(self.compiled.geom_bodyid[deep], axis=1), axis=0)
        return [(self.compiled.body(a).name, self.compiled.body(b).name) for a, b in bodies]
