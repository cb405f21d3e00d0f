"""SRDF: groups of joints, postures and end effectors that a robot's makers name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from cbdsl.robot.robot_xml import refuse_macros, require_robot, robot_text, xml_root
from cbdsl.robot.urdf import UrdfError


class SrdfGroup(NamedTuple):
    """Group of joints, as written.

    Attributes:
        name: Name of the group.
        chains: Base and tip link of each of its chains.
        joints: Names of joints.
        links: Names of links, whose joints to their parents belong to the group.
        groups: Names of its subgroups.
    """

    name: str
    chains: tuple[tuple[str, str], ...]
    joints: tuple[str, ...]
    links: tuple[str, ...]
    groups: tuple[str, ...]


class GroupState(NamedTuple):
    """Named posture of a group: positions by joint, rad or m, one for each axis."""

    name: str
    group: str
    positions: Mapping[str, tuple[float, ...]]


class EndEffector(NamedTuple):
    """End effector of a robot.

    Attributes:
        name: Name of the end effector.
        group: Name of the group of its joints.
        parent_link: Link that carries it.
        parent_group: Group of the arm, if it is named.
    """

    name: str
    group: str
    parent_link: str
    parent_group: str


class SrdfModel(NamedTuple):
    """Semantic description of a robot.

    Attributes:
        path: Path of the file.
        groups: Groups by name.
        states, end_effectors: States and end effectors in the file's order.
        passive: Names of joints without a motor.
        virtual: Names and types of joints between the base and the world.
        separated: Pairs of links whose contacts are ignored, although no joint connects them.
    """

    path: Path
    groups: Mapping[str, SrdfGroup]
    states: tuple[GroupState, ...]
    end_effectors: tuple[EndEffector, ...]
    passive: frozenset[str]
    virtual: Mapping[str, str]
    separated: tuple[tuple[str, str], ...]


def read_srdf(path: Path) -> SrdfModel:
    """Read a semantic description.

    Raises:
        UrdfError: If there is no such file, or it is not SRDF.
    """
    return parse_srdf(robot_text(path), path)


def parse_srdf(text: bytes | str, path: Path) -> SrdfModel:
    """Parse the text of a semantic description; the path is for messages.

    Raises:
        UrdfError: If it is not SRDF.
    """
    root = xml_root(text, path, "SRDF")
    refuse_macros(root, path)
    require_robot(root, path)
    groups = [_group(element) for element in root.findall("group")]
    counts = Counter(group.name for group in groups)
    twice = next((name for name, count in counts.items() if count > 1), None)
    if twice is not None:
        raise UrdfError(f"{path}: it has two groups of the name '{twice}'")
    try:
        states = tuple(_state(element) for element in root.findall("group_state"))
    except ValueError as error:
        raise UrdfError(f"{path}: {error}") from None
    keys = ("name", "group", "parent_link", "parent_group")
    return SrdfModel(
        path=path,
        groups={group.name: group for group in groups},
        states=states,
        end_effectors=tuple(
            EndEffector(*(element.get(key, "") for key in keys))
            for element in root.findall("end_effector")
        ),
        passive=frozenset(each.get("name", "") for each in root.findall("passive_joint")),
        virtual={
            each.get("name", ""): each.get("type", "") for each in root.findall("virtual_joint")
        },
        separated=tuple(
            (element.get("link1", ""), element.get("link2", ""))
            for element in root.findall("disable_collisions")
            if element.get("reason") != "Adjacent"
        ),
    )


def _group(element: ElementTree.Element) -> SrdfGroup:
    def names(tag: str) -> tuple[str, ...]:
        return tuple(each.get("name", "") for each in element.findall(tag))

    chains = tuple(
        (each.get("base_link", ""), each.get("tip_link", "")) for each in element.findall("chain")
    )
    return SrdfGroup(element.get("name", ""), chains, names("joint"), names("link"), names("group"))


def _state(element: ElementTree.Element) -> GroupState:
    name = element.get("name", "")
    positions = {}
    for joint in element.findall("joint"):
        text = joint.get("value", "")
        try:
            positions[joint.get("name", "")] = tuple(map(float, text.split()))
        except ValueError:
            raise ValueError(
                f"group_state '{name}' has value=\"{text}\" for joint '{joint.get('name', '')}', "
                "which should be a number"
            ) from None
    return GroupState(name, element.get("group", ""), positions)
