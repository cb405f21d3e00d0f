"""Obstructions of joints that stay behind their references, by model and measured posture."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from cbdsl.backends.staging.links import pairs_without_contact
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.robot.weight import overloads

# Named contacts; more would not explain more.
_NAMED = 2


def obstructions(
    robot: RobotDocument, model: UrdfModel, positions: Mapping[str, float], joints: Iterable[str]
) -> tuple[str, ...]:
    """Return weights beyond efforts, and contacts of links, that keep joints from following.

    Args:
        robot: Robot document, with efforts and pairs of links that touch nothing.
        model: Model of the robot.
        positions: Measured positions of joints, rad or m.
        joints: Joints that do not follow their references.
    """
    late = tuple(joints)
    try:
        return (*_weights(robot, model, positions, late), *_contacts(robot, model, positions, late))
    except (ImportError, UrdfError):  # meshes need coal, which comes with Pinocchio
        return ()


def _weights(
    robot: RobotDocument, model: UrdfModel, positions: Mapping[str, float], late: tuple[str, ...]
) -> list[str]:
    efforts = {
        name: min(robot.simulation.efforts.get(name, math.inf), model.joints[name].effort)
        for name in late
    }
    over = overloads(model, positions, efforts)
    return [
        f"{name} bears {needed:.3g} of {most:.3g} {'N' if model.joints[name].slides else 'N m'}"
        for name, (needed, most) in over.items()
    ]


def _contacts(
    robot: RobotDocument, model: UrdfModel, positions: Mapping[str, float], late: tuple[str, ...]
) -> list[str]:
    from cbdsl.kinematics.self_contacts import SelfContacts  # only a blocked arm needs it

    ignored = pairs_without_contact(robot, model)
    touching = [
        f"{one} touches {other}"
        for one, other in sorted(SelfContacts(model).touching(positions) - ignored)
        if not {*model.above(one)}.symmetric_difference(model.above(other)).isdisjoint(late)
    ]
    return touching[:_NAMED]
