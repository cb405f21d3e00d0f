"""Declarations of a robot's document about the resources that follow from it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.yaml_text.library import Library, shipped

ROBOTS = sorted((shipped() / "robots").glob("*.yaml"))


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_every_resource_is_declared_in_the_robots_document(path: Path) -> None:
    body = Session().body(path, Diagnostics())
    lines = path.read_text("utf-8").split("\n")
    for name, resource in body.resources.items():
        place = body.declaration(resource)
        word = lines[place.line - 1][place.column - 1 : place.end_column - 1]
        assert Path(place.file) == path
        assert word in {*name.split("."), "cameras"}, name


def test_clash_of_types_reports_where_both_resources_come_from(tmp_path: Path) -> None:
    program = tmp_path / "programs" / "clash.yaml"
    program.parent.mkdir()
    program.write_text(
        "cbdsl: 1\nkind: program\nname: clash\nrobot: dexter\ncontrollers:\n  press:\n"
        "    potential: spring\n    reference: left_hand.finger_1.force\n"
        "    feedback: right_arm.position\n    effector: right_arm\nactions: [press]\n",
        encoding="utf-8",
    )
    (clash,) = check_document(program, session=Session(Library(tmp_path)))
    lines = (shipped() / "robots" / "dexter.yaml").read_text("utf-8").split("\n")
    elsewhere = [r.place for r in clash.related if Path(r.place.file).name == "dexter.yaml"]
    assert clash.code == "CB504"
    assert [lines[p.line - 1].split(":")[0].strip() for p in elsewhere] == ["finger_1", "right_arm"]


def _with_its_programs(name: str, folder: Path) -> list[Path]:
    """Copy a shipped robot and all documents for it."""
    (folder / "robots").mkdir()
    for path in (shipped() / "robots").glob(f"{name}.*"):
        shutil.copy(path, folder / "robots")
    shutil.copytree(shipped() / "programs/stages/meshes", folder / "programs/stages/meshes")
    used = re.compile(f"^robot: ({name}|any)$", re.MULTILINE)
    for place in ("programs", "programs/stages", "knowledge/models"):
        (folder / place).mkdir(parents=True, exist_ok=True)
        for path in (shipped() / place).glob("*.yaml"):
            if used.search(path.read_text("utf-8")):
                shutil.copy(path, folder / place)
    return sorted(folder.rglob("*.yaml"))


def _found(paths: list[Path], folder: Path) -> set[tuple[str, str]]:
    session = Session(Library(folder))
    diagnostics = [found for path in paths for found in check_document(path, session=session)]
    return {(found.code, Path(found.place.file).name) for found in diagnostics}


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_robot_with_an_invalid_model_is_one_finding(path: Path, tmp_path: Path) -> None:
    paths = _with_its_programs(path.stem, tmp_path)
    (tmp_path / "robots" / f"{path.stem}.urdf").write_text("<robot", encoding="utf-8")
    assert len(paths) > 1
    assert _found(paths, tmp_path) == {("CB301", path.name)}


def test_camera_at_an_unknown_link_is_one_finding(tmp_path: Path) -> None:
    paths = _with_its_programs("dexter", tmp_path)
    robot = tmp_path / "robots" / "dexter.yaml"
    text = robot.read_text("utf-8")
    broken = text.replace("left: {link: left_camera", "left: {link: left_camra")
    assert broken != text
    robot.write_text(broken, encoding="utf-8")
    assert _found(paths, tmp_path) == {("CB303", "dexter.yaml")}


@pytest.mark.parametrize(
    ("stated", "code"),
    [
        ("shapes: {left_pam: [{points: [[0 m, 0 m, 0 m]], radius: 5 cm}]}", "CB303"),
        ("ignore: [[left_pam, torso]]", "CB303"),
        ("distance: 40 cm", "CB587"),
        ("distance: 2 N", "CB205"),
        ("keep_out: {pole: {points: [[0 deg, 0 m, 0 m]]}}", "CB205"),
        ("{distance: 2 cm, keep_out: {pole: {points: [[0.3, 0, 0]], radius: 1 m}}}", "CB587"),
    ],
)
def test_clearance_that_does_not_fit_is_one_finding(stated: str, code: str, tmp_path: Path) -> None:
    paths = _with_its_programs("dexter", tmp_path)
    robot = tmp_path / "robots" / "dexter.yaml"
    value = stated if stated[0] == "{" else f"{{{stated}}}"
    robot.write_text(f"{robot.read_text('utf-8')}\nclearance: {value}\n", encoding="utf-8")
    assert _found(paths, tmp_path) == {(code, "dexter.yaml")}
