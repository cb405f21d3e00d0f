"""Public arm with a camera on its flange, as in the docs: checked and run without Python."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pybullet_data
import pytest
import yaml

from tests.cli.test_main import cb
from tests.cli.test_two_arms import block


def test_arm_with_the_camera_of_the_docs_finds_a_ball(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(Path(pybullet_data.getDataPath(), "kuka_iiwa"), tmp_path / "kuka_iiwa")
    model = (tmp_path / "kuka_iiwa" / "model.urdf").read_text("utf-8")
    eye = block("xml", 'link name="eye"').text
    (tmp_path / "kuka_iiwa" / "eye.urdf").write_text(re.sub("</robot>", f"{eye}</robot>", model))
    robot = yaml.safe_load(block("yaml", "name: kuka").text.replace("model.urdf", "eye.urdf"))
    added = yaml.safe_load(block("yml", "cameras:").text)
    robot["control"]["tasks"] |= added.pop("control")["tasks"]
    for folder, name, text in (
        ("robots", "kuka", yaml.safe_dump({**robot, **added})),
        ("programs", "look", block("yml", "name: look").text),
    ):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / f"{name}.yaml").write_text(text, "utf-8")
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, "new", "stage", "table", "--robot", "kuka") == 0
    assert cb(monkeypatch, "validate", "robots", "programs") == 0
    words = ("--context", "on_table", "--backend", "kinematic", "--seed", "1")
    assert cb(monkeypatch, "run", "look", *words) == 0
    assert "Rewarded after" in capsys.readouterr().out
