"""Distances between links that the start posture of a robot does not keep."""

from __future__ import annotations

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.types.resource import LinkDistance

# Validation needs no engine, and a run checks again; faults of a document have findings of their
# own.
_LEFT = ImportError, UrdfError, KeyError


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

        return too_near_at_start(robot, model, least)
    except _LEFT:
        return ""


def is_measured(robot: RobotDocument, model: UrdfModel, source: LinkDistance) -> bool:
    """Return whether links have the shapes for a distance, which a run checks again."""
    try:
        from cbdsl.kinematics.nearest_links import NearestLinks  # imports numpy

        return NearestLinks(robot, model, source).are_known
    except _LEFT:
        return True
