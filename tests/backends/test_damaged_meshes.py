"""Missing and damaged meshes of a robot: the same diagnostic on every engine."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library
from tests.backends.conftest import BACKENDS
from tests.cli.test_main import cb
from tests.robot.meshes.samples import DAMAGED, SOUND
from tests.robots.small_robot import Hinge, SmallRobot, chain, write_robot

EFFECTOR = "effectors: {arm: {joints: [j1], postures: {home: [0 rad]}, start: home}}"
PROGRAM = """cbdsl: 1
kind: program
name: go
robot: small
stage: empty
controllers:
  move: {potential: spring, reference: [0.1 rad], feedback: arm, effector: arm}
actions: [move]
policy: {X: move, "0": move}
"""
STAGE = "cbdsl: 1\nkind: stage\nname: empty\nrobot: small\ncontexts: {only: {}}\n"
#: Formats whose collision meshes PyBullet reads.
READ_BY_BULLET = ("tip.obj", "tip.stl", "tip.dae")


def robot_with(folder: Path, name: str, data: bytes | None, part: str = "collision") -> SmallRobot:
    """Write a small robot whose last link has a mesh."""
    if data is not None:
        (folder / name).write_bytes(data)
    element = f'<{part}><geometry><mesh filename="{name}"/></geometry></{part}>'
    urdf = chain(Hinge()).replace("</link><joint", f"{element}</link><joint")
    assert element in urdf
    return write_robot(folder, urdf, EFFECTOR)


def found_in(robot: SmallRobot) -> dict[str, str]:
    file = robot.folder / "robots" / "small.yaml"
    diagnostics = check_document(file, Session(Library(robot.folder)))
    return {each.code: each.message for each in diagnostics if each.code in ("CB366", "CB741")}


@pytest.mark.parametrize("engine", BACKENDS)
@pytest.mark.parametrize("name", SOUND)
def test_robot_with_sound_mesh_opens_or_names_the_formats(
    name: str, engine: str, tmp_path: Path
) -> None:
    robot = robot_with(tmp_path, name, SOUND[name])
    assert found_in(robot) == {}
    if engine == "bullet" and name not in READ_BY_BULLET:
        with pytest.raises(BackendError, match="OBJ, binary STL or COLLADA"), robot.backend(engine):
            pass
    else:
        with robot.backend(engine):
            pass


@pytest.mark.parametrize("part", ["collision", "visual"])
@pytest.mark.parametrize(("name", "damage"), DAMAGED)
def test_robot_with_damaged_mesh_is_refused_by_the_checker_and_each_engine(
    name: str, damage: str, part: str, tmp_path: Path
) -> None:
    robot = robot_with(tmp_path, name, DAMAGED[name, damage], part)
    message = found_in(robot)["CB366"]
    assert message.startswith(f"mesh '{name}' of link 'l1' is damaged: ")
    for engine in BACKENDS:
        with pytest.raises(BackendError) as raised, robot.backend(engine):
            pass
        assert str(raised.value) == f"small.urdf: {message}"


@pytest.mark.parametrize("part", ["collision", "visual"])
def test_robot_with_missing_mesh_is_refused_by_engines_that_read_it(
    part: str, tmp_path: Path
) -> None:
    robot = robot_with(tmp_path, "none.stl", None, part)
    message = found_in(robot)["CB741"]
    for engine in BACKENDS:
        if engine == "kinematic" or (engine == "mujoco" and part == "visual"):
            with robot.backend(engine):
                continue
        with pytest.raises(BackendError) as raised, robot.backend(engine):
            pass
        assert str(raised.value) == f"small.urdf: {message}"


def test_run_on_any_engine_and_validate_report_a_damaged_mesh_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    robot_with(tmp_path, "tip.stl", DAMAGED["tip.stl", "larger declared"])
    (tmp_path / "programs" / "stages").mkdir(parents=True)
    (tmp_path / "programs" / "go.yaml").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "programs" / "stages" / "empty.yaml").write_text(STAGE, encoding="utf-8")
    assert cb(monkeypatch, "validate", "robots/small.yaml") == 1
    line = capsys.readouterr().out.splitlines()[0]
    assert line.startswith("robots/small.yaml:4:8: CB366 mesh 'tip.stl' of link 'l1' is damaged: ")
    for engine in BACKENDS:
        assert cb(monkeypatch, "run", "go", "--backend", engine) == 1
        assert line in "".join(capsys.readouterr())
