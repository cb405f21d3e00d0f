"""A kind of driver from another package is checked, listed and driven as a built-in one."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.cli.test_main import cb
from tests.conftest import ROOT

pytestmark = pytest.mark.usefixtures("demo")
DRIVERS = """
drivers:
  arm:
    kind: echo
    moves: [arm]
    states: "echo:states"
    commands: "echo:commands"
    deadline: 500 ms
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with the six-axis arm, driven by the package's kind of driver."""
    for file in ("robots/sixaxis.*", "programs/poise.yaml", "programs/stages/sixaxis_*"):
        for path in ROOT.glob(file):
            copy = tmp_path / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, copy)
    robot = tmp_path / "robots" / "sixaxis.yaml"
    robot.write_text(robot.read_text("utf-8") + DRIVERS, "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_driver_kind_is_listed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "drivers", "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["driver kind"] for row in rows] == ["echo", "ros2"]


def test_driver_kind_checks_its_addresses(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = here / "robots" / "sixaxis.yaml"
    assert cb(monkeypatch, "validate", str(robot)) == 0
    robot.write_text(robot.read_text("utf-8").replace("echo:states", "/states"), "utf-8")
    capsys.readouterr()
    assert cb(monkeypatch, "validate", str(robot)) == 1
    assert "'/states' does not begin with 'echo:'" in capsys.readouterr().out


@pytest.mark.slow
def test_driver_kind_drives_a_program(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "run", "poise", "--robot", "sixaxis", "--backend", "ros2", "--yes") == 0
    assert "aside came to rest 0.0 cm from its reference" in capsys.readouterr().out
