"""Diagnostics of a document do not depend on the documents that are checked before it."""

from __future__ import annotations

import random
import re
import shutil
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.program import examine_program
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

#: Roles of the receiving and the giving arm of a handover.
_EXCHANGED = {"arm": "from_arm", "hand": "from_hand", "from_arm": "arm", "from_hand": "hand"}
_ROLE = re.compile(r"\$(from_arm|from_hand|arm|hand)\b")

_PROGRAM = "programs/handover.yaml"
_LEARNED = "knowledge/schemas/pick_and_place.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return documents in which a schema's allocations no longer fit the roles of a program."""
    folder = tmp_path_factory.mktemp("documents")
    for name in ("programs", "knowledge", "robots"):
        shutil.copytree(ROOT / name, folder / name)
    file = folder / _PROGRAM
    text = _ROLE.sub(lambda match: f"${_EXCHANGED[match[1]]}", file.read_text("utf-8"))
    for role, exchanged in (
        ("arm: effector of position", "from_arm: effector of position"),
        ("hand: effector of force on arm", "from_hand: effector of force on from_arm"),
        ("from_arm: arm other than arm", "arm: from_arm other than from_arm"),
        ("from_hand: hand on from_arm", "hand: from_hand on arm"),
    ):
        assert f"  {role}\n" in text
        text = text.replace(f"  {role}\n", f"  {exchanged}\n", 1)
    file.write_text(text, "utf-8")
    return folder


def found(folder: Path, *names: str) -> dict[str, list[str]]:
    """Return the diagnostics of each document, checked in this order in one session."""
    session = Session(Library(folder))
    return {
        name: [f"{d.code} {d.message}" for d in check_document(folder / name, session)]
        for name in names
    }


@pytest.mark.parametrize(
    "before",
    [
        (_PROGRAM,),
        ("robots/panda.yaml", _PROGRAM, "programs/pick_and_place.yaml"),
        ("programs/take.yaml", "knowledge/policies/pick_and_place.yaml", _PROGRAM),
    ],
)
def test_diagnostics_of_a_document_are_those_without_the_documents_before_it(
    folder: Path, before: tuple[str, ...]
) -> None:
    alone = {name: found(folder, name)[name] for name in (*before, _LEARNED)}
    assert any("CB634" in text for text in alone[_LEARNED])
    assert found(folder, *before, _LEARNED) == alone
    assert found(folder, _LEARNED, *before[::-1]) == alone


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_diagnostics_of_all_documents_do_not_depend_on_their_order(folder: Path, seed: int) -> None:
    names = [
        file.relative_to(folder).as_posix()
        for below in ("programs", "knowledge", "robots")
        for file in sorted((folder / below).rglob("*.yaml"))
    ]
    first = found(folder, *names)
    random.Random(seed).shuffle(names)
    assert found(folder, *names) == first


def test_recalled_check_of_a_program_binds_its_robot_again() -> None:
    """Readers see a program with the robot of the last check, recalled or not."""
    session = Session(Library(ROOT))
    path, used = (session.library.locate(ProgramDocument, name) for name in ("stack", "set_on"))
    for robot in ("dexter", "panda", "dexter", "panda"):
        examine_program(path, {"robot": robot}, session, Diagnostics())
        for each in (path, used):
            assert session.library.read(each, ProgramDocument).document.robot == robot
