"""Notes on assumptions about a robot's model: reported once, never errors, in every format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.test_main import cb

JOINT = """
  <joint name="{name}" type="revolute">
    <parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="{effort}" velocity="2"/>
  </joint>"""
BOX = "<{use}><geometry><box size='0.1 0.1 0.1'/></geometry></{use}>"
INERTIA = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
SOLID = BOX.format(use="visual") + BOX.format(use="collision")
SEEN, HEAVY, FRAME = BOX.format(use="visual"), f"{INERTIA}</inertial>", ""

ROBOT = """cbdsl: 1
kind: robot
name: arm
model: arm.urdf
base: base
effectors:
  arm: {joints: [turn, bend]}
%s
control:
  rate: 120 Hz
  tasks: {configuration: {gain: 4 /s, quiescence: {rate: 0.05, window: 0.2 s}}}
"""
PROGRAM = """cbdsl: 1
kind: program
name: turning
robot: arm
stage: nothing
controllers:
  turn: {potential: spring, reference: [0.2 rad, 0.2 rad], feedback: arm, effector: arm}
actions: [turn]
"""
STAGE = "cbdsl: 1\nkind: stage\nname: nothing\nrobot: arm\ncontexts: {alone: {}}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("robots", "programs/stages"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "programs/turning.yaml").write_text(PROGRAM)
    (tmp_path / "programs/stages/nothing.yaml").write_text(STAGE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(folder: Path, *, base: str, upper: str, lower: str, effort: float, more: str = "") -> str:
    """Write a robot of three links in series, and return its file."""
    links = {"base": base, "upper": upper, "lower": lower}
    parts = "".join(f'\n  <link name="{name}">{text}</link>' for name, text in links.items())
    parts += JOINT.format(name="turn", parent="base", child="upper", effort=effort)
    parts += JOINT.format(name="bend", parent="upper", child="lower", effort=10)
    (folder / "robots/arm.urdf").write_text(f'<robot name="arm">{parts}\n</robot>')
    (folder / "robots/arm.yaml").write_text(ROBOT % more)
    return "robots/arm.yaml"


def test_visible_and_heavy_links_without_collision_are_named_in_one_note(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(folder, base=FRAME, upper=SEEN, lower=HEAVY, effort=10)
    assert cb(monkeypatch, "validate", "--strict", ".") == 0
    out = capsys.readouterr().out
    note = "CB742 (note) links of arm.urdf without <collision> touch nothing: upper, lower"
    assert out.count("CB742") == 1 and note in out and out.endswith("1 note\n")


def test_solid_links_frames_and_cameras_are_not_worth_a_note(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(folder, base=FRAME, upper=SOLID, lower=SOLID, effort=10)
    assert cb(monkeypatch, "validate", "robots") == 0
    assert "no findings" in capsys.readouterr().out
    cameras = "cameras: {eye: {link: lower, width: 64, height: 64, focal_length: 60 px}}"
    write(folder, base=FRAME, upper=SOLID, lower=SEEN, effort=10, more=cameras)
    cb(monkeypatch, "validate", "robots")
    assert "CB742" not in capsys.readouterr().out


def test_effort_of_0_is_noted_unless_the_document_bounds_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write(folder, base=FRAME, upper=SOLID, lower=SOLID, effort=0)
    assert cb(monkeypatch, "validate", file, "--format", "json") == 0
    report = json.loads(capsys.readouterr().out)
    (diagnostic,) = report["findings"]
    assert (diagnostic["code"], diagnostic["severity"], report["notes"]) == ("CB743", "note", 1)
    assert report["warnings"] == report["errors"] == 0
    assert diagnostic["message"].endswith("taken for no limit, to turn")
    write(
        folder,
        base=FRAME,
        upper=SOLID,
        lower=SOLID,
        effort=0,
        more="simulation: {efforts: {turn: 5 N m}}",
    )
    cb(monkeypatch, "validate", file)
    assert "no findings" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("form", "told"), [("github", "::notice file="), ("sarif", '"level": "note"')]
)
def test_json_and_sarif_contain_notes(
    form: str,
    told: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write(folder, base=FRAME, upper=SEEN, lower=SOLID, effort=10)
    assert cb(monkeypatch, "validate", ".", "--format", form) == 0
    assert told in capsys.readouterr().out


def test_notes_of_a_robot_are_reported_for_its_document_and_not_for_its_users(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(folder, base=SOLID, upper=SEEN + HEAVY, lower=SOLID, effort=0)
    for words in (
        ["run", "turning", "--backend", "kinematic"],
        ["validate", "programs"],
        ["validate", "programs/turning.yaml"],
    ):
        assert cb(monkeypatch, *words) == 0
        printed = "".join(capsys.readouterr())
        assert "note" not in printed and "CB74" not in printed, words
    assert cb(monkeypatch, "validate", "arm", "programs/turning.yaml") == 0
    printed = capsys.readouterr().out
    assert [printed.count(code) for code in ("CB742 (note)", "CB743 (note)")] == [1, 1]


def test_comment_silences_a_note(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write(folder, base=SOLID, upper=SEEN, lower=SOLID, effort=1)
    path = folder / file
    text = path.read_text().replace("arm.urdf\n", "arm.urdf  # cb: ignore CB742 it is a cable\n")
    path.write_text(text)
    cb(monkeypatch, "validate", ".")
    assert "no findings" in capsys.readouterr().out


def test_run_with_errors_omits_notes(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(folder, base=SOLID, upper=SEEN, lower=SOLID, effort=1)
    program = folder / "programs" / "turning.yaml"
    program.write_text(program.read_text().replace("feedback: arm", "feedback: arms"))
    assert cb(monkeypatch, "run", "turning", "--backend", "kinematic") == 1
    printed = "".join(capsys.readouterr())
    assert "CB501" in printed and "CB742" not in printed
