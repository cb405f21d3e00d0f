"""The resources of the shipped robot against the sets of section 3.2."""

from __future__ import annotations

from collections import Counter

import pytest

from cbdsl.documents.robot import Group, RobotDocument
from cbdsl.robot.channel_names import named_colors
from cbdsl.robot.resources import resources
from cbdsl.types.resource import (
    FingerLoad,
    Heading,
    Headings,
    NetLoad,
    StereoPosition,
)
from cbdsl.yaml_text.library import Library

_GROUP_PARTS = (".position", ".centroid", ".separation")


@pytest.fixture(scope="module")
def robot() -> RobotDocument:
    library = Library()
    return library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document


def test_counts_are_those_of_the_source(robot: RobotDocument) -> None:
    found = resources(robot).values()
    synergies = [r.type.size for r in found if r.name in robot.effectors]
    assert sorted(synergies) == [2, 4, 4, 7, 7]
    sources = Counter(
        type(r.source)
        for r in set(found)
        if r.name.split(".")[-1] not in named_colors(robot.vision.channels)
    )
    assert sources[Heading] == 3 * 31 and sources[StereoPosition] == 31
    assert sources[Headings] == 31
    # Per hand, forces, torques and wrenches of three fingers, and their sums (Eq 3.9).
    assert sources[FingerLoad] == 2 * 3 * 3 and sources[NetLoad] == 2 * 3


def test_names_are_those_of_the_entries(robot: RobotDocument) -> None:
    assert all(name == resource.name for name, resource in resources(robot).items())


def test_aliases_mean_their_channels(robot: RobotDocument) -> None:
    channels = robot.vision.channels.model_copy(
        update={"aliases": {"red": "hue_1", "vivid": "sat_10"}}
    )
    vision = robot.vision.model_copy(update={"channels": channels})
    found = resources(robot.model_copy(update={"vision": vision}))
    for alias, channel in channels.aliases.items():
        assert found[f"stereo.{alias}"].source == found[f"stereo.{channel}"].source


def test_effectors_and_tips_can_be_moved_and_nothing_else(robot: RobotDocument) -> None:
    grouped = {f"{name}{part}" for name in robot.groups for part in ("", *_GROUP_PARTS)}
    movable = {r.name for r in resources(robot).values() if r.movable} - grouped
    tips = {name for name, effector in robot.effectors.items() if effector.tip is not None}
    parts = {f"{name}.{part}" for name in tips for part in ("position", "orientation", "pose")}
    assert movable == set(robot.effectors) | parts


def test_finger_forces_are_a_product(robot: RobotDocument) -> None:
    forces = resources(robot)["right_hand.finger_forces"].type
    assert (str(forces), forces.size) == ("force x 3", 9)


def test_group_has_the_resources_of_all_its_members(robot: RobotDocument) -> None:
    found = resources(robot)
    assert str(found["arms"].type) == "configuration[14]"
    assert str(found["arms.position"].type) == "position x 2"
    assert str(found["hands.net_forces"].type) == "force x 2"
    assert (
        "arms.ready" in found and "hands.position" not in found and "arms.net_forces" not in found
    )


def test_group_with_an_unknown_member_has_no_resources(robot: RobotDocument) -> None:
    group = Group(members=("left_arm", "third_arm"))
    lame = robot.model_copy(update={"groups": {"arms": group}})
    assert not [name for name in resources(lame) if name.startswith("arms")]


def test_positions_are_triangulated_with_two_cameras_only(robot: RobotDocument) -> None:
    one = robot.model_copy(update={"cameras": {"left": robot.cameras["left"]}})
    blind = robot.model_copy(update={"cameras": {}})
    assert not [name for name in resources(one) if name.startswith("stereo.")]
    assert "cyclopean.motion" in resources(one)
    assert not [r for r in resources(blind).values() if isinstance(r.source, Heading)]
