"""Lookup of documents by name."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT


def test_shipped_documents_are_found_from_anywhere(tmp_path: Path) -> None:
    library = Library(tmp_path)
    assert library.find(RobotDocument, "dexter") is not None
    assert library.find(StageDocument, "table_right") is not None
    assert "searchtrack" in library.names(ProgramDocument)


def test_nearest_folder_comes_first(tmp_path: Path) -> None:
    near, far = tmp_path / "a" / "robots", tmp_path / "robots"
    for folder in (near, far):
        folder.mkdir(parents=True)
        (folder / "dexter.yaml").write_text("", encoding="utf-8")
    beside = tmp_path / "a" / "programs" / "own.yaml"
    library = Library(tmp_path)
    assert library.find(RobotDocument, "dexter", beside) == near / "dexter.yaml"
    assert library.find(RobotDocument, "dexter") == far / "dexter.yaml"


def test_path_stays_a_path_and_a_name_is_looked_up(tmp_path: Path) -> None:
    library = Library(tmp_path)
    assert library.locate(ProgramDocument, "some/where") == Path("some/where")
    assert library.locate(ProgramDocument, "searchtrack").name == "searchtrack.yaml"
    with pytest.raises(UsageError, match="did you mean 'searchtrack'"):
        library.locate(ProgramDocument, "searchtrak")


def test_file_is_read_once() -> None:
    library = Library()
    path = library.locate(ProgramDocument, "searchtrack")
    assert library.read(path, ProgramDocument) is library.read(path.absolute(), ProgramDocument)


def test_neighbour_of_the_right_kind_precedes_shipped_documents(tmp_path: Path) -> None:
    own = tmp_path / "own.yaml"
    neighbour = tmp_path / "searchtrack.yaml"
    neighbour.write_text("cbdsl: 1\nkind: program\nname: searchtrack\n", encoding="utf-8")
    (tmp_path / "dexter.yaml").write_text("kind: program\n", encoding="utf-8")
    library = Library(tmp_path / "elsewhere")
    assert library.find(ProgramDocument, "searchtrack", own) == neighbour
    assert library.find(RobotDocument, "dexter", own) != tmp_path / "dexter.yaml"
    assert "dexter" in library.names(ProgramDocument, own)


def test_model_beside_the_folder_of_policies_precedes_shipped_ones(tmp_path: Path) -> None:
    name = "searchtrack_head"
    model = tmp_path / "any" / "models" / f"{name}.yaml"
    model.parent.mkdir(parents=True)
    model.write_bytes((ROOT / "knowledge" / "models" / f"{name}.yaml").read_bytes())
    policy = tmp_path / "any" / "policies" / "x.yaml"
    library = Library(tmp_path)
    assert library.find(ModelDocument, name, policy) == model
    assert name in library.names(ModelDocument, policy)
    assert library.find(ModelDocument, name) != model


def test_name_is_resolved_as_in_a_document_of_the_folder(tmp_path: Path) -> None:
    own = tmp_path / "own.yaml"
    own.write_text("cbdsl: 1\nkind: program\nname: own\n", encoding="utf-8")
    library = Library(tmp_path)
    assert library.locate(ProgramDocument, "own") == own
    with pytest.raises(UsageError, match="unknown stage 'own'"):
        library.locate(StageDocument, "own")
    with pytest.raises(UsageError, match="did you mean 'own'"):
        library.locate(ProgramDocument, "ownn")


def test_folder_does_not_hide_the_document_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Folders of a robot's model or of a run's recording likely have the name of its document."""
    monkeypatch.chdir(tmp_path)
    own, folder = Path("own.yaml"), Path("own")
    own.write_text("cbdsl: 1\nkind: program\nname: own\n", encoding="utf-8")
    folder.mkdir()
    library = Library(tmp_path)
    assert library.locate(ProgramDocument, "own") == own
    assert library.locate_any("own") == [own]
    (folder / "other.yaml").write_text("cbdsl: 1\n", encoding="utf-8")
    assert library.locate_any("own") == [folder]
    Path("empty").mkdir()
    assert library.locate_any("empty") == [Path("empty")]


@pytest.mark.parametrize(
    ("kind", "goes_on"),
    [("program", True), ("policy", True), ("robot", False), ("calibration", False)],
)
def test_replace_of_a_file_returns_whether_parsed_documents_stay_valid(
    kind: str, goes_on: bool, tmp_path: Path
) -> None:
    library, path = Library(tmp_path), tmp_path / "own.yaml"
    text = f"cbdsl: 1\nkind: {kind}\n".encode()
    assert not library.replace(path, text), "it may be found by a name from now on"
    assert library.replace(path, text + b"name: own\n") == goes_on
    assert library.replace(path, b"kind: stage\n") == goes_on
    assert library.text(path) == "kind: stage\n"


def test_replace_with_another_kind_forgets_the_file_of_a_name(tmp_path: Path) -> None:
    library, path = Library(tmp_path), tmp_path / "programs" / "own.yaml"
    path.parent.mkdir()
    path.write_text("cbdsl: 1\nkind: program\n", encoding="utf-8")
    beside = path.with_name("other.yaml")
    library.replace(path, path.read_bytes())
    assert library.find(ProgramDocument, "own", beside) == path
    path.write_text("cbdsl: 1\nkind: stage\n", encoding="utf-8")
    assert library.replace(path, path.read_bytes())
    (tmp_path / "programs" / "programs").mkdir()
    own = tmp_path / "programs" / "programs" / "own.yaml"
    own.write_text("cbdsl: 1\nkind: program\n", encoding="utf-8")
    assert library.find(ProgramDocument, "own", beside) == own


def test_stage_is_found_in_the_folder_of_stages_beside_a_program(tmp_path: Path) -> None:
    stage = tmp_path / "stages" / "one.yaml"
    stage.parent.mkdir()
    stage.write_text("cbdsl: 1\nkind: stage\nname: one\n", "utf-8")
    library = Library(tmp_path)
    assert library.locate(StageDocument, "one") == stage
    assert library.find(StageDocument, "one", tmp_path / "program.yaml") == stage
    assert "one" in library.names(StageDocument, tmp_path / "program.yaml")
