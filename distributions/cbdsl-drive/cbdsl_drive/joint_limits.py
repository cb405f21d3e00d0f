"""Limits of a driven robot's joints, from its URDF and its drivers."""

from __future__ import annotations

import numpy as np

from cbdsl.extend.backend import Joints, RobotDocument
from cbdsl.extend.driver import UrdfModel, acceleration
from cbdsl_drive.limiter import JointLimits


def joint_limits(robot: RobotDocument, model: UrdfModel) -> JointLimits:
    """Return the limits of a robot's actuated joints, in the order of ``Joints.names``.

    Joints without a velocity limit in the URDF have that of the robot's control law.
    """
    joints = [model.joints[name] for name in Joints(robot).names]
    # The limiter needs finite speeds; see ``Limiter``.
    fallback = robot.control.joint_speed
    speeds = [joint.velocity if np.isfinite(joint.velocity) else fallback for joint in joints]
    drivers = {
        joint: driver
        for driver in robot.drivers.values()
        for effector in driver.moves
        for joint in robot.joints(effector)
    }
    accelerations = [
        acceleration(drivers.get(joint.name), speed)
        for joint, speed in zip(joints, speeds, strict=True)
    ]
    return JointLimits(
        np.array([joint.lower for joint in joints]),
        np.array([joint.upper for joint in joints]),
        np.array(speeds),
        np.array(accelerations),
        np.array([joint.effort for joint in joints]),
    )
