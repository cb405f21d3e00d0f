"""Limits of a driven robot's joints, from its URDF and its drivers."""

from __future__ import annotations

import numpy as np

from cbdsl.backends.drivers.limiter import JointLimits
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel

# Time to the largest speed where a driver states no acceleration, s.
_RAMP = 0.05


def joint_limits(robot: RobotDocument, model: UrdfModel) -> JointLimits:
    """Return the limits of a robot's actuated joints, in the order of ``Joints.names``.

    Joints without a velocity limit in the URDF have that of the robot's control law.
    """
    joints = [model.joints[name] for name in Joints(robot).names]
    # The limiter needs finite speeds; see ``Limiter``.
    fallback = robot.control.joint_speed
    speeds = [joint.velocity if np.isfinite(joint.velocity) else fallback for joint in joints]
    stated = {
        joint: driver.acceleration
        for driver in robot.drivers.values()
        for effector in driver.moves
        for joint in robot.joints(effector)
    }
    accelerations = [
        stated.get(joint.name) or speed / _RAMP for joint, speed in zip(joints, speeds, strict=True)
    ]
    return JointLimits(
        np.array([joint.lower for joint in joints]),
        np.array([joint.upper for joint in joints]),
        np.array(speeds),
        np.array(accelerations),
        np.array([joint.effort for joint in joints]),
    )
