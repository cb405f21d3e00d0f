"""Displacement of a joint: the pose of its child where it is not at zero."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.kinematics.pose import Pose
from cbdsl.robot.urdf import UrdfJoint


def displacement(joint: UrdfJoint, position: float) -> Pose:
    """Return the pose of a joint's child, relative to that at zero.

    Args:
        joint: Joint that turns, slides, or is fixed.
        position: Position of the joint, rad or m.
    """
    # The axis of a fixed joint means nothing, and is 0 in some models.
    axis = np.array(joint.axis) / (math.hypot(*joint.axis) or 1.0)
    if joint.slides:
        return Pose(position * axis, np.eye(3))
    return Pose.turned(axis, position)
