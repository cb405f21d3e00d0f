"""Effectors of a robot that fit the roles of a program (Sections 8.2 and 8.3)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.documents.program import ProgramDocument
from cbdsl.types.role import EYES, RELATIONS, STEREO, STEREO_HEADING, Role


class Binding(NamedTuple):
    """Effectors in the roles of a program.

    Attributes:
        effectors: Effector by role.
        refusal: Reason why they do not fit; empty if they do.
    """

    effectors: Mapping[str, str]
    refusal: str


def bindings(
    roles: Mapping[str, Role], robot: CheckedRobot, values: Mapping[str, str]
) -> Iterator[Binding]:
    """Yield each choice of effectors of the right kinds, fitting or not.

    Args:
        roles: Roles by name.
        robot: Robot.
        values: Given effectors by role.
    """
    choices = [
        [values[name]] if name in values else _candidates(each, robot)
        for name, each in roles.items()
    ]
    for chosen in itertools.product(*choices):
        effectors = dict(zip(roles, chosen, strict=True))
        yield Binding(effectors, _refusal(roles, effectors, robot))


def _candidates(own: Role, robot: CheckedRobot) -> list[str]:
    """Return the effectors with the signals that a role needs."""
    if own.wanted.type == STEREO:
        return [STEREO] if robot.document.has_stereo else []
    return [name for name in robot.document.effectors if has_signal(own.wanted.type, name, robot)]


def unfilled(name: str, own: Role, robot: CheckedRobot, values: Mapping[str, str]) -> str:
    """Return why no effector can be in a role at all; empty if one can."""
    document, kind = robot.document, own.wanted.type
    sought, held = f"effector of {kind}", list(document.effectors)
    known, whose = [*document.effectors, *document.groups], f"robot '{document.name}'"
    if kind == STEREO:
        known, sought, held = [STEREO], "two cameras", list(document.cameras)
    if name not in values:
        listed = ", ".join(held) or "none"
        problem = f"{whose} has no {sought} for role '{name}' (it has {listed})"
        return "" if _candidates(own, robot) else problem
    given = values[name]
    if given not in known:
        return f"{whose} has no effector '{given}' for role '{name}' (it has {', '.join(known)})"
    lacks = f"'{given}' of {whose} has no signal of {kind}, which role '{name}' needs"
    return "" if has_signal(kind, given, robot) else lacks


def _refusal(roles: Mapping[str, Role], effectors: Mapping[str, str], robot: CheckedRobot) -> str:
    for name, each in roles.items():
        own, carrier = effectors[name], effectors.get(each.on)
        if carrier is not None and (own == carrier or not carries(carrier, own, robot)):
            return f"'{own}' is not {RELATIONS[0]} '{carrier}'"
        if each.other and effectors[each.other] == own:
            return f"'{own}' is in both roles '{each.other}' and '{name}'"
    return ""


def groups_of(document: ProgramDocument, roles: Mapping[str, Role]) -> dict[str, dict[str, str]]:
    """Return the groups of roles that are replaced together: an arm with its hand."""
    groups: dict[str, dict[str, str]] = {}
    for name, each in roles.items():
        if each.wanted.kind == EYES:
            continue
        first = next((key for key, group in groups.items() if each.on in group), name)
        groups.setdefault(first, {})[name] = f"effector of {each.wanted.type}"
    return groups


def has_signal(kind: str, effector: str, robot: CheckedRobot) -> bool:
    """Return whether an effector, or each member of a group, has a signal of a type."""
    if kind == STEREO:
        return effector == STEREO and robot.document.has_stereo
    members = robot.document.members(effector)
    if kind == STEREO_HEADING:
        links = [camera.link for camera in robot.document.main_cameras.values()]
        turned = (robot.moves(each, link) for each in members for link in links)
        return robot.document.has_stereo and all(turned)
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
