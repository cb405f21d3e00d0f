"""Drivers of robot documents: invalid drivers are found before any motion."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from cbdsl.api.reading.robots import read_robot
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
        ("    kind", "    stop: /stop\n    kind", "it needs 'stop_deadline', such as 250 ms"),
        ("    kind", "    stop_deadline: 1 s\n    kind", "it has no 'stop'"),
        (
            "    kind",
            "    stop: /stop\n    stop_deadline: 10 s\n    kind",
            "10 s are more than 1 s",
        ),
        (
            "    kind",
            "    stop: /stop\n    stop_deadline: 5 ms\n    kind",
            "5 ms are less than one and a half control periods",
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
            "    images: {middle: /i}\n    camera_info: {middle: /c}\n    kind",
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


def test_stop_that_sends_changes_alone_is_a_stated_choice(tmp_path: Path) -> None:
    stop = "    stop: /stop\n    stop_repeats: false\n"
    assert diagnostics(tmp_path, GOOD + stop + WRENCHES) == []


@pytest.mark.parametrize(("tracking", "finding"), [(None, True), ("2 cm", False), ("5 cm", True)])
def test_driver_whose_tracking_no_sliding_joint_exceeds_is_found(
    tracking: str | None, finding: bool, tmp_path: Path
) -> None:
    shutil.copytree(ROOT / "robots", tmp_path / "robots")
    arm = {"kind": "ros2", "moves": ["arm"], "states": "/states", "commands": "/arm"}
    gripper = {**arm, "moves": ["hand"], "commands": "/gripper", "start": "1 cm"}
    gripper |= {} if tracking is None else {"tracking": tracking}
    file = tmp_path / "robots" / "panda.yaml"
    drivers = json.dumps({"arm": arm, "gripper": gripper})
    file.write_text(f"{file.read_text('utf-8')}\ndrivers: {drivers}\n", "utf-8")
    found = [each.message for each in check_document(file)]
    assert len(found) == finding, found
    assert all("'panda_finger_joint1' moves by 0.04 m at most" in each for each in found)


STOP = "    stop: /stop\n    stop_deadline: 250 ms\n"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("rate: 60 Hz", "rate: 31 Hz", "CB325"),
        (
            STOP,
            f"{STOP}    start: 0.02\n",
            "and 'start', 0.02, would hold it; state at least 0.025",
        ),
        ("lead: 0.12 rad", "lead: 0.1 rad", "'control.lead' keeps references within 0.1 of"),
        (STOP, "    stop: /stop\n", "it needs 'stop_deadline', such as 250 ms"),
        ("250 ms", "20 ms", "20 ms are less than one and a half control periods"),
        ("250 ms", "20 s", "20 s are more than 1 s"),
        (STOP, f"{STOP}    deadline: 20 ms\n", "20 ms are less than one and a half control"),
        (STOP, f"{STOP}    deadline: 200 ms\n    acceleration: 10 rad/s^2\n", "CB325"),
        (STOP, f"{STOP}    skew: 0.2 s\n", "0.2 s are more than 0.15 s"),
        (
            "stop: /stop",
            "form: positions\n    stop: /c/guarded",
            "the watchdog of 'commands' reads",
        ),
        (STOP, f"{STOP}    tracking: 0.2 rad\n", "'tracking', 0.2, has no effect"),
        (STOP, f"{STOP}    start: 0.2 rad\n", "'start', 0.2, is more than 'tracking', 0.1"),
    ],
)
def test_clause_of_the_contract_that_cannot_hold_is_one_finding(
    old: str, new: str, expected: str, tmp_path: Path
) -> None:
    text = (ROOT / "robots" / "dexter.yaml").read_text("utf-8")
    head, rest = text.split("drivers:\n")
    tail = rest[rest.index("\nsimulation:") :]
    good = GOOD.replace("/controller/joint_trajectory", "/c")
    whole = f"{head}drivers:\n  body:{good}{STOP}{tail}"
    assert old in whole
    shutil.copytree(ROOT / "robots", tmp_path / "robots")
    file = tmp_path / "robots" / "dexter.yaml"
    file.write_text(whole.replace(old, new, 1), "utf-8")
    found = [f"{each.code} {each.message}" for each in check_document(file)]
    about_drivers = [text for text in found if text.startswith("CB32")]
    assert len(about_drivers) == 1, found
    assert expected in about_drivers[0]


TWO = """
    kind: ros2
    moves: [left_arm, left_hand, head]
    states: /joint_states
    commands: /left/commands
    stop: /stop
    stop_deadline: 250 ms
    KEYS
  other:
    kind: ros2
    moves: [right_arm, right_hand]
    states: /joint_states
    commands: /right/commands
    stop: /stop
    stop_deadline: 250 ms
    MORE
"""


def two(tmp_path: Path, keys: str = "", more: str = "") -> list[str]:
    """Return the diagnostics of Dexter with two drivers that share two streams."""
    return diagnostics(tmp_path, TWO.replace("    KEYS\n", keys).replace("    MORE\n", more))


def test_drivers_may_share_joint_states_and_an_emergency_stop(tmp_path: Path) -> None:
    assert two(tmp_path) == []


@pytest.mark.parametrize(
    ("keys", "more", "expected"),
    [
        ("    deadline: 5 s\n", "", "'body' cannot be used: 5 s are more than 1 s"),
        ("    deadline: 50\n", "", "50 s are more than 1 s"),
        ("    horizon: 2 s\n", "", "2 s are more than 1 s"),
        ("    skew: 1e9 s\n", "", "1e+09 s are more than 0.15 s"),
        ("    skew: -5 ms\n", "", "'-5 ms' given, more than 0 required"),
        ("    deadline: 5 mm\n", "", "expected time"),
        ("    state: /joints\n", "", "CB202 unknown key 'state'"),
        ("    start: 1 rad\n", "", "'start', 1, is more than 'tracking', 0.1"),
        ("    tracking: 1 deg\n", "", "'start', 0.05, is more than 'tracking'"),
        ("    tracking: 100 rad\n", "", "so that it is never farther than 'tracking', 100"),
        ("    tracking: 0.12 rad\n", "", "'control.lead' keeps references within 0.12 of the"),
        ("    stop_repeats: false\n", "", "'stop_repeats: false' leaves it without effect"),
        ("    horizon: 100 ms\n", "", "CB325 driver 'body' stands 183 ms after its program"),
        ("    description: /stop\n", "", "driver 'body' has '/stop' as its 'description' already"),
        ("    description: stop\n", "", "driver 'body' has '/stop' as its 'description' already"),
        ("", "    images: {left: /left/commands}\n    camera_info: {left: /i}\n",
         "driver 'body' has '/left/commands' as its 'commands' already"),
        ("", "    wrenches: {left_hand: {finger_1: /joint_states}}\n",
         "driver 'body' has '/joint_states' as its 'states' already"),
        ("    wrenches: {left_hand: {finger_1: /w}}\n",
         "    wrenches: {left_hand: {finger_1: /x}}\n", "driver 'body' has it already"),
        ("    wrenches: {left_hand: {finger_1: /w, finger_2: w}}\n", "", "has it already"),
        ("    joints: {pan: tilt}\n", "", "'tilt' is the name of 'pan' too"),
        ("    joints: {pan: ''}\n", "", "its name in messages is empty"),
        ("    joints: {pan: a}\n", "    joints: {RIGHT: a}\n", "'a' is the name of 'pan' too"),
        ("    images: {left: /l}\n", "", "'camera_info' lacks camera 'left'"),
        ("    camera_info: {left: /l}\n", "", "neither 'images' nor 'regions' of 'left'"),
    ],
)  # fmt: skip
def test_drivers_with_a_mistake_have_one_finding(
    keys: str, more: str, expected: str, tmp_path: Path
) -> None:
    right = read_robot("dexter")[0].joints("right_arm")[0]
    found = two(tmp_path, keys, more.replace("RIGHT", right))
    assert len(found) == 1, found
    assert expected in found[0]
