"""Distances between links that the start posture of a robot does not keep."""

from __future__ import annotations

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfError, UrdfModel


def unkept_clearance(robot: RobotDocument, model: UrdfModel, least: float) -> str:
    """Return a clause about the links that start too near each other, or an empty text.

    Args:
        robot: Robot document.
        model: Model of the robot.
        least: Least distance, m, if that of the robot is less.
    """
    least = max(least, robot.clearance.distance or 0.0)
    if least == 0.0:
        return ""
    try:
        from cbdsl.kinematics.link_clearance import too_near_at_start  # imports numpy
    except ImportError:
        return ""  # validation needs no engine, and a run checks again
    try:
        return too_near_at_start(robot, model, least)
    except (UrdfError, KeyError):
        return ""  # faults of the document, which have findings of their own
