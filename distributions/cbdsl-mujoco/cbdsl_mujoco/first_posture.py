"""Posture in which episodes begin, and the links that overlap in it."""

from __future__ import annotations

from typing import Any

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import Joints, RobotDocument, UrdfModel
from cbdsl_mujoco.robot_spec import compile_spec

# Depth of one link inside another that is impossible in the world, m.
_OVERLAP = 0.001


class FirstPosture:
    """Robot at rest in the posture in which episodes begin.

    Args:
        spec: Specification of the robot; not changed.
        robot: Robot document, which names joints and postures.
        model: URDF model of the robot.

    Attributes:
        compiled: MuJoCo's model.
        data: State of the model.

    Raises:
        BackendError: The robot cannot be simulated.
    """

    def __init__(self, spec: Any, robot: RobotDocument, model: UrdfModel) -> None:
        joints = Joints(robot)
        self.compiled = compile_spec(spec.copy(), model)
        self.data = mj.MjData(self.compiled)
        start = np.zeros(len(joints.names))
        for name, posture in robot.start_postures.items():
            start[joints.of(name)] = posture
        rows = [int(self.compiled.joint(name).qposadr[0]) for name in joints.all]
        self.data.qpos[rows] = joints.expand(start)
        mj.mj_forward(self.compiled, self.data)

    def overlaps(self) -> list[tuple[str, str]]:
        """Return the pairs of bodies that are inside each other.

        Hulls are larger than meshes, and the links of many public models overlap as well. No force
        can separate them, and contact forces would throw the robot about.
        """
        deep = self.data.contact.geom[self.data.contact.dist < -_OVERLAP]
        bodies = np.unique(np.sort(self.compiled.geom_bodyid[deep], axis=1), axis=0)
        return [(self.compiled.body(a).name, self.compiled.body(b).name) for a, b in bodies]
