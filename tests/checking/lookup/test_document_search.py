"""Missing documents that are named: only suitable documents are proposed."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.lookup.document_search import for_robot
from cbdsl.checking.session import Session
from cbdsl.diagnostics.catalogue import catalogue
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.types.relative import ANY_ROBOT
from cbdsl.yaml_text.library import Library

PROGRAM = (
    "cbdsl: 1\nkind: program\nname: move\nrobot: example\nstage: {}\ncontrollers:\n  move: "
    "{{potential: range, feedback: head, effector: head, gain: 1, "
    "quiescence: {{rate: 1, window: 1}}}}\nactions: [move]\n"
)

#: Stages for any robot.
ANY = ("cube_and_pad", "cube_on_bench", "cubes_to_stack", "over_bench")


@pytest.fixture
def library(tmp_path: Path) -> Library:
    example = catalogue()["CB302"]
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "example.yaml").write_text(example.good, "utf-8")
    urdf = "robots/example.urdf"
    (tmp_path / urdf).write_text(example.beside[urdf], "utf-8")
    return Library(tmp_path)


def stage_fault(library: Library, stage: str) -> Diagnostic:
    path = library.here / "move.yaml"
    path.write_text(PROGRAM.format(stage), "utf-8")
    (found,) = (
        f for f in check_document(path, session=Session(Library(library.here))) if f.is_error
    )
    return found


@pytest.mark.parametrize(("stage", "code"), [("absent", "CB603"), ("nowhere", "CB602")])
def test_robot_without_stages_of_its_own_has_those_for_any(
    library: Library, stage: str, code: str
) -> None:
    found = stage_fault(library, stage)
    assert found.code == code and found.allowed == ANY


def test_only_stages_of_the_robot_and_of_any_robot_are_proposed(library: Library) -> None:
    own = "cbdsl: 1\nkind: stage\nname: own\nrobot: example\ncontexts: {always: {}}\n"
    folder = library.here / "programs" / "stages"
    folder.mkdir(parents=True)
    (folder / "own.yaml").write_text(own, "utf-8")
    assert stage_fault(library, "absent").allowed == (*ANY, "own")
    assert stage_fault(library, "onw").nearest == "own"


def test_for_robot_returns_documents_that_name_the_robot_or_any() -> None:
    library = Library()
    for kind in (StageDocument, ProgramDocument):
        found = {name: for_robot(kind, name, None, library) for name in ("dexter", "sixaxis")}
        assert found["dexter"]
        for robot_name, names in found.items():
            for name in names:
                file = library.find(kind, name)
                assert file is not None
                assert library.read(file, kind).document.robot in (robot_name, ANY_ROBOT)
