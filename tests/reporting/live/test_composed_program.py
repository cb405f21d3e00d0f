"""Programs composed by hand: valid documents that contain the composition."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.program.controller import Literal
from cbdsl.reporting.live.composed_program import Changes, ComposedProgram, composed_program
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.reader import formatted_text
from tests.conftest import ROOT

NOTHING = Changes({}, {}, None)
LEFT = {"arm": "left_arm", "hand": "left_hand", "feature": "sat_10"}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return Path(shutil.copy(ROOT / "programs" / "reachtouch.yaml", tmp_path))


def made(file: Path, changes: Changes, values: dict[str, str] | None = None) -> ComposedProgram:
    return composed_program(file, "table_right", values or {}, changes, "mine")


def test_stack_is_the_only_action_of_its_document(file: Path) -> None:
    changes = Changes({"approach": 5.0}, {"approach": (0.5, -0.2, 0.1)}, ("approach", "orient"))
    composed = made(file, changes, LEFT)
    assert composed.diagnostics == () and composed.left_out == ()
    saved = file.with_name("mine.yaml")
    saved.write_text(composed.text, encoding="utf-8")
    assert check_document(saved) == []
    assert "with arm=left_arm, hand=left_hand." in composed.text
    program = check_program(saved, {"arm": "left_arm", "hand": "left_hand"}, Library(file.parent))
    assert program.name == "mine" and program.parameters["arm"] == "left_arm"
    assert [action.name for action in program.actions] == [
        "orient", "approach", "orient ◁ approach",
    ]  # fmt: skip
    assert dict(program.policy) == {"**": "orient ◁ approach"}
    approach = program.primitives["approach"].lead
    assert approach.gain == 5.0 and approach.effector.name == "left_arm.position"
    assert approach.reference == Literal((0.5, -0.2, 0.1))
    assert {each.name for each in program.background.primitives} == {"home", "preshape"}  # type: ignore[union-attr]
    assert formatted_text(composed.text, "mine") == composed.text


def test_without_a_stack_the_program_stays_with_its_changes(file: Path) -> None:
    composed = made(file, Changes({"touch": 2.5}, {}, None))
    assert composed.diagnostics == ()
    assert composed.text.count("gain:") == 1 and "gain: 2.5 /s" in composed.text
    for kept in ("searchtrack_table", "X10: reach ◁ touch", "posture ◁ orient ◁ approach"):
        assert kept in composed.text


def test_required_controllers_are_kept_in_a_composed_program(file: Path) -> None:
    composed = made(file, Changes({}, {}, ("touch",)))
    assert "once: approach" in composed.text and "  approach:\n" in composed.text
    assert "  orient:\n" not in composed.text and "searchtrack" not in composed.text


def test_findings_are_reported_and_changes_of_other_programs_left_out(file: Path) -> None:
    composed = made(file, Changes({"searchtrack.track": 3.0}, {}, ("posture", "home")))
    assert composed.left_out == ("searchtrack.track",)
    assert [each.code for each in composed.diagnostics] == ["CB709"]


@pytest.mark.parametrize("name", ["", "../etc/passwd", "a b", "1a", "a.yaml", "x\n"])
def test_only_names_of_programs_are_taken(file: Path, name: str) -> None:
    with pytest.raises(ValueError, match="not a name of a program"):
        composed_program(file, "table_right", {}, NOTHING, name)
