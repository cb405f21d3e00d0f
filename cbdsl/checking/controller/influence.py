"""Which effectors move which signals."""

from __future__ import annotations

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.types.casts import chains
from cbdsl.types.resource import DRAWN, Origin, Resource

# What is drawn or written down is no measurement, and stays as it is.
_STILL = DRAWN | {Origin.CONSTANT}


def is_measured(resource: Resource) -> bool:
    """Whether a resource is a signal, and no draw and no constant."""
    return resource.origin not in _STILL


def moves(body: CheckedRobot, effector: Resource, feedback: Resource) -> bool:
    """Whether an effector can be moved, and moves a feedback, as far as anybody can tell."""
    if not effector.movable or not chains(feedback.type, effector.type):
        return False
    influence = body.influence(feedback)
    return influence is None or not influence.isdisjoint(body.effector_joints(effector))


def movers(body: CheckedRobot, feedback: Resource) -> list[str]:
    """The names of all effectors that move a feedback."""
    return [
        resource.name for resource in body.resources.values() if moves(body, resource, feedback)
    ]
