"""Requests of runs: the program that a command runs, and messages about unclear requests."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.api.load import load
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library

PROGRAM = """cbdsl: 1
kind: program
name: own
robot: {robot}
controllers: {{}}
actions: [still]
use: {{still: {{program: {used}}}}}
"""


@pytest.mark.parametrize(("robot", "used"), [("sixaxis", "poise"), ("panda", "poise")])
def test_only_stages_of_the_same_robot_are_proposed(
    robot: str, used: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.yaml").write_text(PROGRAM.format(robot=robot, used=used), encoding="utf-8")
    with pytest.raises(UsageError, match="own names no stage") as error:
        load("own.yaml")
    proposed = str(error.value).partition("known: ")[2].rstrip(")").split(", ")
    library = Library()
    for name in library.names(StageDocument):
        file = library.locate(StageDocument, name)
        stage = library.read(file, StageDocument).document
        assert (name in proposed) == (stage.robot in (robot, "any"))
