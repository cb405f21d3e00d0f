"""Two public arms combined as in the docs: created, checked, run and replayed without Python."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pybullet_data
import pytest

from cbdsl.robot.urdf_reader import read_urdf
from tests.cli.test_main import cb
from tests.conftest import ROOT
from tests.test_docs import Block, blocks

pytest.importorskip("xacro", reason="extra formats")
STAGE = "cbdsl: 1\nkind: stage\nname: pair_bench\nrobot: pair\ncontexts: {empty: {}}\n"


def block(language: str, word: str) -> Block:
    """Return the block of the page that contains a word."""
    page = blocks(ROOT / "docs" / "how_to" / "new_robot.md")
    (found,) = [each for each in page if each.language == language and word in each.text]
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the page's shell commands on the public model, and return the folder."""
    folder = tmp_path_factory.mktemp("pair")
    shutil.copytree(Path(pybullet_data.getDataPath(), "kuka_iiwa"), folder / "kuka_iiwa")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    script = block("sh", "pair.urdf.xacro").text
    subprocess.run(["sh", "-ec", script], cwd=folder, env={**os.environ, "PATH": path}, check=True)
    (folder / "programs" / "stages").mkdir(parents=True)
    (folder / "programs" / "stages" / "pair_bench.yaml").write_text(STAGE)
    (folder / "programs" / "hold.yaml").write_text(block("yml", "name: hold").text)
    return folder


def test_new_robot_of_two_arms_has_a_group_and_no_diagnostics(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    assert cb(monkeypatch, "validate", "--strict", ".") == 0
    assert "3 documents, no findings" in capsys.readouterr().out
    joints = read_urdf(folder / "robots" / "pair.urdf").movable
    assert len(joints) == 14 and {name.split("_")[0] for name in joints} == {"left", "right"}
    # Each arm brings the model's materials, and a reader takes one of each name.
    materials = ElementTree.parse(folder / "robots" / "pair.urdf").getroot().findall("material")
    names = [each.get("name") for each in materials]
    assert "Grey" in names and len(names) == len(set(names))


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "bullet"])
def test_both_hands_come_to_rest_40_cm_apart(
    backend: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    kept = folder / backend
    words = ("run", "hold", "--backend", backend, "--record", str(kept), "--json")
    assert cb(monkeypatch, *words) == 0
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert result["ending"].startswith("Done") and "far" not in result["ending"]
    assert result["sim_seconds"] < 3
    assert cb(monkeypatch, "replay", str(kept)) == 0
    assert (kept / "episode_0.html").stat().st_size > 100_000


def test_two_materials_of_one_name_are_a_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Kinematics cannot read such a model; the checker reports it first."""
    monkeypatch.chdir(tmp_path)
    grey = '<material name="grey"><color rgba="{} 0.5 0.5 1"/></material>'
    text = (ROOT / "robots" / "desk.urdf").read_text("utf-8").replace("</robot>", "{}{}</robot>")
    (tmp_path / "desk.urdf").write_text(text.format(grey.format(0.5), grey.format(0.4)))
    assert cb(monkeypatch, "new", "robot", "twice", "--urdf", "desk.urdf") == 2
    assert "two materials of the name 'grey'" in capsys.readouterr().err
