"""Names of shared controllers in an editor: definition, hover, completion and rename."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from cbdsl.editor.buffers import Buffers
from cbdsl.editor.cursor import Cursor, cursor
from cbdsl.editor.hover import hover
from cbdsl.editor.language_server import definition
from cbdsl.editor.rename import renaming
from cbdsl.editor.shared_names import shared_choices
from tests.conftest import ROOT
from tests.editor.test_rename import diagnostics, rename

SET_ON = "programs/set_on.yaml"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to a copy of the documents that one program needs."""
    for name in ("robots", "programs", "knowledge/models"):
        shutil.copytree(ROOT / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def at(here: Path, file: str, mark: str) -> tuple[Buffers, Path, Cursor]:
    """Return the cursor after a mark."""
    buffers, path = Buffers(here), here / file
    text = path.read_text("utf-8")
    place = text.index(mark) + len(mark)
    line = text.count("\n", 0, place)
    return buffers, path, cursor(text.splitlines(), line, place - text.rfind("\n", 0, place) - 1)


@pytest.mark.parametrize(
    ("mark", "file", "start"),
    [
        ("background: sea", "looking", "search(model):"),
        ("  hold: ho", "holding", "hold(hand, force, shut):"),
        ("looking: [sea", "looking", "search(model):"),
    ],
)
def test_definition_of_a_shared_name_is_in_its_document(
    here: Path, mark: str, file: str, start: str
) -> None:
    found = definition(*at(here, SET_ON, mark))
    assert found is not None and found[0].stem == file
    assert found[0].read_text("utf-8").splitlines()[found[1]].strip().startswith(start)


def test_hover_over_a_call_shows_the_shared_declaration(here: Path) -> None:
    shown = hover(*at(here, SET_ON, "background: sea"))
    assert shown is not None and "head.$model" in shown


def test_completion_proposes_shared_names(here: Path) -> None:
    buffers, path, spot = at(here, SET_ON, "looking: [sea")
    assert "watch" in {each.name for each in shared_choices(buffers, path, spot.steps)}
    calls = {each.name for each in shared_choices(buffers, path, ("background",))}
    assert {"search(model)", "watch(object)"} <= calls


@pytest.mark.parametrize(
    ("file", "mark"), [(SET_ON, "background: sea"), ("programs/shared/looking.yaml", "\n  sea")]
)
def test_shared_controller_is_renamed_in_all_programs(here: Path, file: str, mark: str) -> None:
    before = diagnostics("programs")
    named = rename(here, file, mark, "scan")
    assert named is not None and named.old == "search" and len(named.spots) > 5
    assert "search" in (here / "programs/searchtrack.yaml").read_text("utf-8")
    assert diagnostics("programs") == before


def test_renamed_shared_controller_leaves_own_names_alone(here: Path) -> None:
    named = renaming(*at(here, SET_ON, "  hold: ho"))
    assert named is not None and {"set_on", "holding"} <= {each.stem for each in named.spots}
    for spot in named.spots[here / SET_ON]:
        line = (here / SET_ON).read_text("utf-8").splitlines()[spot.line]
        assert line[spot.end :].startswith("(") or "holding:" in line
