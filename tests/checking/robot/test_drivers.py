"""Drivers of robot documents: invalid drivers are found before any motion."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from tests.conftest import ROOT

GOOD = """
    kind: ros2
    moves: [head, left_arm, right_arm, left_hand, right_hand]
    states: /joint_states
    commands: /controller/joint_trajectory
"""
WRENCHES = "    wrenches: {left_hand: {finger_1: /touch}}\n"


def diagnostics(tmp_path: Path, drivers: str) -> list[str]:
    """Return the diagnostics of Dexter with other drivers."""
    text = (ROOT / "robots" / "dexter.yaml").read_text("utf-8")
    head, rest = text.split("drivers:\n")
    tail = rest[rest.index("\nsimulation:") :]
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "dexter.urdf").write_bytes(
        (ROOT / "robots" / "dexter.urdf").read_bytes()
    )
    file = tmp_path / "robots" / "dexter.yaml"
    file.write_text(f"{head}drivers:\n  body:{drivers}{tail}", "utf-8")
    return [f"{each.code} {each.message}" for each in check_document(file)]


def test_shipped_drivers_have_no_findings(tmp_path: Path) -> None:
    assert diagnostics(tmp_path, GOOD + WRENCHES) == []


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("ros2", "ros3", "CB321 unknown kind of driver 'ros3'"),
        (
            "/joint_states",
            "joint states",
            "CB322 driver 'body' cannot be used: 'joint states' is not",
        ),
        ("/joint_states", "~/states", "'~/states' is private to a node"),
        ("/joint_states", "/a__b", "'/a__b' is not a topic"),
        ("head, ", "", "CB323 no driver moves effector 'head'"),
        ("head, ", "heat, ", "CB308 'heat' is not a known effector"),
        ("    commands: /controller/joint_trajectory\n", "", "it has no 'commands'"),
        ("    states: /joint_states\n", "", "it has no 'states'"),
        ("    kind", "    deadline: 1 ms\n    kind", "1 ms are less than one and a half control"),
        ("    kind", "    horizon: 5 ms\n    kind", "5 ms are less than one and a half control"),
        ("    kind", "    tracking: 5 cm\n    kind", "the joints that it moves have rad"),
        (
            "    kind",
            "    acceleration: 5 m/s^2\n    kind",
            "the joints that it moves have rad/s^2",
        ),
        ("    kind", "    options: {speed: 3}\n    kind", "kind ros2 has no option 'speed'"),
        (
            "    kind",
            "    joints: {pam: j1}\n    kind",
            "CB308 'pam' is not a known joint of 'moves'",
        ),
        ("    kind", "    joints: {pan: j, tilt: j}\n    kind", "'j' is the name of 'pan' too"),
        (
            "    kind",
            "    images: {middle: /image}\n    kind",
            "CB308 'middle' is not a known camera",
        ),
        ("    kind", "    regions: {left: '9'}\n    kind", "'9' is not a topic of ROS 2"),
        (
            "left_hand: {finger_1",
            "left_hand: {thumb",
            "CB308 'thumb' is not a known finger of 'left_hand'",
        ),
        ("{left_hand: {", "{left_arm: {", "CB308 'left_arm' is not a known hand with load cells"),
        (
            "    kind",
            "    kind: ros2\n    moves: [head]\n    states: /s\n"
            "    commands: /controller/joint_trajectory\n  other:\n    kind",
            "has it already",
        ),
        (
            "    kind",
            "    kind: ros2\n    moves: [head]\n    states: /s\n    commands: /c\n"
            "  other:\n    kind",
            "driver 'body' moves effector 'head' already",
        ),
    ],
)
def test_driver_that_cannot_work_is_found(
    tmp_path: Path, old: str, new: str, expected: str
) -> None:
    drivers = GOOD + WRENCHES
    assert old in drivers
    found = diagnostics(tmp_path, drivers.replace(old, new, 1))
    assert any(expected in diagnostic for diagnostic in found), found
