"""Effectors that move a signal."""

from __future__ import annotations

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.types.casts import Chain, chains
from cbdsl.types.resource import Origin, Resource
from cbdsl.types.source_record import chains_of


def is_measured(resource: Resource) -> bool:
    """Return whether a resource is a signal, neither a draw nor a constant."""
    return not resource.is_drawn and resource.origin is not Origin.CONSTANT


def moves(body: CheckedRobot, effector: Resource, feedback: Resource) -> bool:
    """Return whether an effector moves a feedback; true if it is movable and the rest unknown."""
    if not effector.movable or not chains(feedback.type, effector.type):
        return False
    influence = body.influence(feedback)
    return influence is None or not influence.isdisjoint(body.effector_joints(effector))


def movers(body: CheckedRobot, feedback: Resource) -> list[str]:
    """Return the names of all effectors that move a feedback."""
    return [
        resource.name for resource in body.resources.values() if moves(body, resource, feedback)
    ]


def acting_chains(body: CheckedRobot, feedback: Resource, effector: Resource) -> tuple[Chain, ...]:
    """Return the chains from a feedback to the joints along which an effector moves it."""
    # A heading has one chain through the cameras and one through a hand that holds the object. An
    # arm without a camera moves the heading along the second chain alone.
    joints, all_chains = body.effector_joints(effector), chains_of(feedback)
    moved = tuple(
        chain for chain in all_chains if not body.joints_of(feedback, chain).isdisjoint(joints)
    )
    return moved or all_chains[:1]  # without a decision from the model
