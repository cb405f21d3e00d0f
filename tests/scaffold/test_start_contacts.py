"""``cb new robot`` for a model whose links overlap: it rests in its start posture."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.self_contacts import SelfContacts
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import Library
from tests.cli.test_main import cb
from tests.kinematics.test_self_contacts import two_arms


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def proposed(folder: Path, monkeypatch: pytest.MonkeyPatch, urdf: str) -> RobotDocument:
    (folder / "two_arms.urdf").write_text(urdf)
    assert cb(monkeypatch, "new", "robot", "two_arms", "--urdf", "two_arms.urdf", "--force") == 0
    return Library(folder).read(folder / "robots" / "two_arms.yaml", RobotDocument).document


def moved(folder: Path, robot: RobotDocument, engine: str) -> float:
    """Return the largest joint displacement after holding the start posture for a second, rad."""
    from cbdsl.backends.backend import embody

    backend = embody(engine, robot, folder / "two_arms.urdf")
    head = {"cbdsl": 1, "kind": "stage", "name": "empty", "robot": "two_arms"}
    stage = StageDocument.model_validate({**head, "contexts": {"empty": {}}})
    backend.reset(stage, None, np.random.default_rng(0))
    start = [angle for e in robot.effectors.values() for angle in e.postures[e.start or ""]]
    for _ in range(round(1 / backend.control_period)):
        backend.apply(np.array(start))
        backend.step()
    far = float(np.abs(backend.observe().positions - start).max())
    backend.close()
    return far


@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_robot_whose_links_overlap_holds_its_posture(
    engine: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = proposed(folder, monkeypatch, two_arms())
    assert ("cuff", "left") in robot.simulation.no_contact
    assert ("left", "right") not in robot.simulation.no_contact
    assert moved(folder, robot, engine) < 0.005
    simulation = robot.simulation.model_copy(update={"no_contact": ()})
    if engine == "bullet":  # whose contacts are hard
        bare = robot.model_copy(update={"simulation": simulation})
        assert moved(folder, bare, engine) > 0.02


def test_contacts_at_the_start_posture_are_reported(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # The arms are nearer than they are wide, and zero is in the middle of their ranges.
    near = two_arms().replace("0.08 -0.05 0.3", "0.08 0.02 0.3")
    robot = proposed(folder, monkeypatch, near)
    told = capsys.readouterr().err
    assert "links that touch each other where it starts, but not everywhere: " in told
    assert "left and right" in told and "cuff and left" not in told
    assert ("left", "right") in robot.simulation.no_contact
    text = (folder / "robots" / "two_arms.yaml").read_text()
    assert "# in every posture that was tried\n" in text and "# where it starts\n" in text


def test_missing_mesh_reader_is_reported_with_the_unchecked_contacts(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "coal", None)
    robot = proposed(folder, monkeypatch, two_arms())
    assert robot.simulation.no_contact == ()
    assert "links that touch each other were not looked for" in capsys.readouterr().err


def broad_arms(apart: float) -> str:
    """Return a robot with two parallel arms of three joints, whose upper links are 12 cm wide."""
    inertia = (
        '<inertial><mass value="0.5"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" '
        'ixz="0" iyz="0"/></inertial>'
    )
    box = (
        '<collision><origin xyz="0.2 0 0"/><geometry><box size="0.2 0.12 0.05"/></geometry>'
        "</collision>"
    )
    parts = ['<link name="base"/>']
    for side, y in (("left", apart / 2), ("right", -apart / 2)):
        parent, at = "base", f"0 {y} 0.8"
        for n, axis in enumerate(("0 0 1", "0 1 0", "0 1 0")):
            link = f"{side}_{n}"
            parts += [
                f'<link name="{link}">{inertia}{box if n else ""}</link>',
                f'<joint name="{side}_joint_{n}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{link}"/><origin xyz="{at}"/><axis xyz="{axis}"/>'
                '<limit lower="-2" upper="2" effort="100" velocity="2"/></joint>',
            ]
            parent, at = link, "0 0 0" if n == 0 else "0.35 0 0"
        parts += [
            f'<link name="{side}_hand"/><joint name="{side}_mount" type="fixed">'
            f'<parent link="{parent}"/><child link="{side}_hand"/><origin xyz="0.35 0 0"/></joint>'
        ]
    return f'<robot name="two_arms">{"".join(parts)}</robot>'


@pytest.mark.parametrize("apart", [0.04, 0.08, 0.11])
def test_arms_that_meet_are_turned_apart(
    apart: float,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    robot = proposed(folder, monkeypatch, broad_arms(apart))
    assert "where it starts" not in capsys.readouterr().err
    assert robot.simulation.no_contact == ()
    starts = [each.postures[each.start or ""] for each in robot.effectors.values()]
    model = read_urdf(folder / "two_arms.urdf")
    names = [joint for each in robot.effectors.values() for joint in each.joints]
    at = dict(zip(names, [angle for start in starts for angle in start], strict=True))
    assert not SelfContacts(model).touching(at)
    assert any("apart" in each.postures for each in robot.effectors.values())


def test_arms_with_room_are_not_turned(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = proposed(folder, monkeypatch, broad_arms(0.5))
    assert not any("apart" in each.postures for each in robot.effectors.values())
