"""Programs made of programs, which need no controllers, and others, which name missing sections."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library

HEAD = "cbdsl: 1\nkind: program\nname: a\nrobot: dexter\nstage: absent\nactions: [left]\n"
POLICY = "policy: {X: left, '0': left}\n"
USE = "use: {left: {program: posture}}\n"


def codes(tmp_path: Path, text: str) -> list[str]:
    path = tmp_path / "a.yaml"
    path.write_text(text, encoding="utf-8")
    diagnostics = check_document(path, Session(Library(tmp_path)))
    return [f"{each.code} {each.message}" for each in diagnostics if each.is_error]


@pytest.mark.parametrize("controllers", ["", "controllers: {}\n"])
def test_program_of_programs_needs_no_controllers(tmp_path: Path, controllers: str) -> None:
    assert codes(tmp_path, HEAD + POLICY + USE + controllers) == []


@pytest.mark.parametrize("use", ["", "use: {}\n"])
def test_program_without_used_programs_needs_controllers(tmp_path: Path, use: str) -> None:
    assert codes(tmp_path, HEAD + POLICY + use) == ["CB203 the key 'controllers' is missing"]


def test_faulty_use_hides_no_further_fault_and_adds_none(tmp_path: Path) -> None:
    found = codes(tmp_path, HEAD + POLICY + "use: {left: {prgrm: posture}}\n")
    assert found and not any("'controllers'" in each for each in found)


def test_empty_controllers_section_is_reported(tmp_path: Path) -> None:
    (found,) = codes(tmp_path, HEAD + POLICY + USE + "controllers:\n")
    assert found.startswith("CB204")
