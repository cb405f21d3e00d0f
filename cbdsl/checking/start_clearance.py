"""Distances between links that the start posture of a robot does not keep."""

from __future__ import annotations

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.types.resource import LinkDistance


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


def is_measured(robot: RobotDocument, model: UrdfModel, source: LinkDistance) -> bool:
    """Return whether links have the shapes for a distance, which a run checks again."""
    try:
        from cbdsl.kinematics.nearest_links import NearestLinks  # imports numpy
    except ImportError:
        return True
    try:
        return NearestLinks(robot, model, source).are_known
    except (UrdfError, KeyError):
        return True  # faults of the document, which have findings of their own
