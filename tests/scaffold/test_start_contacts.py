"""``cb new robot`` for a model whose links overlap: it rests in its start posture."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
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
def test_a_robot_whose_links_overlap_holds_its_posture(
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
