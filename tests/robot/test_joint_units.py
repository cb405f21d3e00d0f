"""Units of turning and sliding joints, from the model through literals to every view."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.completions import choices
from cbdsl.editor.cursor import cursor
from cbdsl.editor.hover import hover
from cbdsl.program.dry_run import controllers
from cbdsl.runtime.recording import triple
from cbdsl.types.resource_type import POSE, WRENCH, configuration
from cbdsl.yaml_text.library import Library
from tests.cli.test_main import cb

_JOINT = (
    '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="9" velocity="1"/></joint>'
)
URDF = (
    '<robot name="lifter"><link name="base"/><link name="post"/><link name="arm"/>'
    + '<link name="rail"/><link name="wrist"/>'
    + _JOINT.format("lift", "prismatic", "base", "post")
    + _JOINT.format("turn", "revolute", "post", "arm")
    + _JOINT.format("slide", "prismatic", "arm", "rail")
    + _JOINT.format("roll", "revolute", "rail", "wrist")
    + "</robot>"
)
ROBOT = """\
cbdsl: 1
kind: robot
name: lifter
model: lifter.urdf
base: base
effectors:
  lift: {joints: [lift], postures: {low: [0 m]}}
  turn: {joints: [turn], postures: {ahead: [0 rad]}}
  both: {joints: [slide, roll], postures: {home: [5 cm, 10 deg]}}
groups:
  all: {members: [lift, turn]}
control:
  rate: 120 Hz
  tasks: {configuration: {gain: 2 /s, quiescence: {rate: 0.01, window: 0.2 s}}}
"""
UNITS = {"lift": "m", "turn": "rad", "both": "m, rad", "all": "m, rad"}
PROGRAM = """\
cbdsl: 1
kind: program
name: go
robot: lifter
controllers:
  move: {{potential: spring, reference: {reference}, feedback: {effector},
    effector: {effector}{more}}}
actions: [move]
policy: {{"*": move}}
"""
FITTING = {"lift": "[4 cm]", "turn": "[30 deg]", "both": "[4 cm, 30 deg]", "all": "[4 cm, 30 deg]"}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with a robot that has joints of both kinds."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lifter.urdf").write_text(URDF)
    (tmp_path / "lifter.yaml").write_text(ROBOT)
    return tmp_path


def written(effector: str, reference: str, more: str = "") -> Path:
    text = PROGRAM.format(effector=effector, reference=reference, more=more)
    Path("go.yaml").write_text(text)
    return Path("go.yaml")


def messages(file: Path) -> list[str]:
    """Return the errors in a document, each as code and message."""
    found = check_document(file, Session(Library()))
    return [f"{each.code} {each.message}" for each in found if each.is_error]


@pytest.mark.parametrize(
    ("kind", "units"),
    [
        (configuration(2), ("rad", "rad")),
        (configuration(2, ["m", "m"]), ("m", "m")),
        (configuration(3, ["rad", "rad", "m"]), ("rad", "rad", "m")),
        (configuration(2, ["rad", "m"]).times(2), ("rad", "m", "rad", "m")),
        (POSE, ("m",) * 3 + ("rad",) * 3),
        (WRENCH, ("N",) * 3 + ("N m",) * 3),
    ],
)
def test_type_with_several_units_has_one_for_each_component(
    kind: Any, units: tuple[str, ...]
) -> None:
    assert kind.units == units


@pytest.mark.parametrize("effector", UNITS)
def test_views_of_a_configuration_show_the_units_of_its_joints(
    effector: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    unit, file = UNITS[effector], written(effector, FITTING[effector])
    cb(monkeypatch, "show", "resources", "--robot", "lifter", "--json")
    rows = {row["resource"]: row["unit"] for row in json.loads(capsys.readouterr().out)}
    assert {rows[effector], rows[f"{effector}.uniform"]} == {unit}
    cb(monkeypatch, "show", "program", "go")
    shown = capsys.readouterr().out
    assert f"configuration[{len(unit.split(','))}] in {unit}" in " ".join(shown.split())
    cb(monkeypatch, "show", "program", "go", "--json")
    data = json.loads(capsys.readouterr().out)
    assert {row["unit"] for row in data["resources"]} == {unit}
    assert data["controllers"][0]["reference"].endswith(f"] {unit}")
    (controller,) = controllers(check_program(file, {}, Library()))
    assert triple(controller)["unit"] == unit
    buffers, lines = Buffers(here), file.read_text().splitlines()
    at = cursor(lines, 5, lines[5].index("feedback: ") + 10)
    assert f", {unit}, proprioception" in str(hover(buffers, here / file, at))
    offered = {choice[0]: choice[1] for choice in choices(buffers, here / file, at.steps)}
    assert offered[effector].endswith(f", {unit}")


@pytest.mark.parametrize("effector", UNITS)
def test_literal_in_the_units_of_the_joints_is_accepted(effector: str, here: Path) -> None:
    for reference in (FITTING[effector], f"here + {FITTING[effector]}", "0", "0 m", "0 rad"):
        is_single = reference.startswith("0 ")
        fits = not is_single or reference.split()[1] in UNITS[effector]
        assert (
            messages(written(effector, f"{reference!r}" if "h" in reference else reference)) == []
        ) == fits


@pytest.mark.parametrize(
    ("effector", "reference", "wanted"),
    [
        ("lift", "[0.1 rad]", "length"),
        ("turn", "[10 cm]", "angle"),
        ("both", "[1 rad, 1 rad]", "length"),
        ("both", "[1 cm, 1 cm]", "angle"),
        ("all", "[10 deg, 10 deg]", "length"),
        ("lift", "here + 30 deg", "length"),
    ],
)
def test_literal_in_other_units_is_refused(
    effector: str, reference: str, wanted: str, here: Path
) -> None:
    (message,) = messages(written(effector, reference))
    assert message.startswith("CB506") and f"expected {wanted}" in message


@pytest.mark.parametrize(
    ("effector", "option", "fits"),
    [
        ("lift", "speed: 5 cm/s", True),
        ("lift", "speed: 5 deg/s", False),
        ("turn", "speed: 5 deg/s", True),
        ("turn", "speed: 5 cm/s", False),
        ("both", "speed: 5 cm/s", True),
        ("both", "speed: 5 deg/s", True),
        ("lift", "acceleration: 1 m/s^2", True),
        ("lift", "acceleration: 1 rad/s^2", False),
        ("lift", "quiescence: {rate: 0.01, window: 0.2 s, tolerance: 2 mm}", True),
        ("lift", "quiescence: {rate: 0.01, window: 0.2 s, tolerance: 2 deg}", False),
        ("turn", "quiescence: {rate: 0.01, window: 0.2 s, tolerance: 2 mm}", False),
    ],
)
def test_option_in_units_of_joints_is_accepted_and_others_are_refused(
    effector: str, option: str, fits: bool, here: Path
) -> None:
    found = [each[:5] for each in messages(written(effector, FITTING[effector], f", {option}"))]
    assert found == ([] if fits else ["CB506"])


def test_reference_of_another_unit_is_refused_with_both_units(here: Path) -> None:
    (message,) = messages(written("lift", "turn.ahead"))
    assert message.startswith("CB504")
    assert "configuration[1] in rad" in message and "configuration[1] in m" in message


def test_literal_without_a_model_is_accepted_in_either_unit(here: Path) -> None:
    Path("lifter.urdf").unlink()
    for reference in ("[4 cm]", "[4 deg]"):
        assert [each[:5] for each in messages(written("lift", reference))] == ["CB301"]


def test_reference_beyond_the_short_way_of_an_endless_joint_is_warned_of(here: Path) -> None:
    Path("lifter.urdf").write_text(URDF.replace('"revolute"', '"continuous"'))
    counting = ROBOT.replace("{joints: [turn],", "{joints: [turn], count_turns: true,")
    for reference, is_short in (
        ("'here + 720 deg'", False),
        ("'here - 200 deg'", False),
        ("'here + 180 deg'", True),
        ("[360 deg]", True),
        ("[450 deg]", False),
        ("turn.ahead", True),
    ):
        for robot in (ROBOT, counting):
            Path("lifter.yaml").write_text(robot)
            found = check_document(written("turn", reference), Session(Library()))
            warned = [each.code for each in found if not each.code.startswith("CB74")]
            assert warned == ([] if is_short or robot is counting else ["CB723"])


def test_field_between_the_limits_of_an_endless_joint_is_refused(here: Path) -> None:
    Path("lifter.urdf").write_text(URDF.replace('"revolute"', '"continuous"'))
    field = ", field: {spacing: 0.1, scale: 0.2}"
    file = written("turn", "[30 deg]", field)
    file.write_text(file.read_text().replace("potential: spring", "potential: harmonic"))
    assert messages(file) == [
        "CB524 joint 'turn' has no limits: the field needs both lower and upper"
    ]
    file.write_text(file.read_text().replace("{spacing", "{lower: [-3], upper: [3], spacing"))
    assert messages(file) == []
    file.write_text(file.read_text().replace("[30 deg]", "[390 deg]"))
    assert messages(file) == []
