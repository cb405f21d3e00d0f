"""Descriptions: the URDF that a robot publishes of itself, compared with its document's."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from cbdsl.extend.driver import UrdfError, UrdfJoint, UrdfModel, parse_urdf

# Relative tolerance for limits that were rounded when written.
_ROUNDING = 1e-3
# Most joints that a sentence names.
_LISTED = 4


def description_problems(
    urdf: str, model: UrdfModel, joints: Sequence[str], names: Mapping[str, str]
) -> list[str]:
    """Return the differences between a robot's own URDF and its document's, one sentence each.

    Args:
        urdf: URDF of the robot, as text.
        model: URDF of the robot's document.
        joints: Actuated joints, by their names in the document.
        names: Names of joints in the robot's own URDF, if they differ.
    """
    try:
        described = parse_urdf(urdf, Path("robot_description"))
    except UrdfError as error:
        return [f"the robot's description cannot be read: {error}"]
    named = {name: names.get(name, name) for name in joints}
    missing = [f"'{theirs}'" for theirs in named.values() if theirs not in described.joints]
    # With missing joints the whole description is suspect, so differences of the other joints are
    # not listed.
    if missing:
        listed = ", ".join(missing[:_LISTED])
        more = f" and {len(missing) - _LISTED} more" if len(missing) > _LISTED else ""
        kind = "joint" if len(missing) == 1 else "joints"
        return [f"the robot's description has no {kind} {listed}{more}: another robot?"]
    return [
        difference
        for name, theirs in named.items()
        for difference in _differences(model.joints[name], described.joints[theirs])
    ]


def _differences(own: UrdfJoint, other: UrdfJoint) -> list[str]:
    if own.kind != other.kind:
        return [f"joint '{own.name}' is {other.kind} by the robot, and {own.kind} by its document"]
    limits = {
        "lower limit": (own.lower, other.lower),
        "upper limit": (own.upper, other.upper),
        "velocity limit": (own.velocity, other.velocity),
    }
    return [
        f"joint '{own.name}' has the {limit} {theirs:g} by the robot, and {ours:g} by its document"
        for limit, (ours, theirs) in limits.items()
        # Infinite limits on both sides count as equal; their difference would be NaN.
        if not math.isclose(ours, theirs, rel_tol=_ROUNDING, abs_tol=_ROUNDING)
    ]
