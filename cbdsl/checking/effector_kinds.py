"""Tests of effectors: whether they have a signal, and whether they carry others."""

from __future__ import annotations

from cbdsl.checking.robot.checked_robot import CheckedRobot


def has_signal(kind: str, effector: str, robot: CheckedRobot) -> bool:
    """Return whether an effector, or each member of a group, has a signal of a type."""
    members = robot.document.members(effector)
    if kind == "force":
        return all(member in robot.document.load_cells for member in members)
    if kind == "configuration":
        return True
    return all(f"{member}.{kind}" in robot.resources for member in members)


def carries(one: str, other: str, robot: CheckedRobot) -> bool:
    """Return whether an effector, or each member of a group, carries another or its member."""
    document, model = robot.document, robot.model
    carriers, carried = document.members(one), document.members(other)
    if model is None or len(carriers) != len(carried):
        return False
    return all(
        robot.moves(carrier, model.joints[joint].child)
        for carrier, load in zip(carriers, carried, strict=True)
        for joint in document.effectors[load].joints
        if joint in model.joints
    )
