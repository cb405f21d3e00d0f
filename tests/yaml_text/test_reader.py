"""Any file is a document or a located finding, never another exception."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.yaml_text.library import shipped
from cbdsl.yaml_text.reader import read, read_document

SEARCHTRACK = shipped() / "programs" / "searchtrack.yaml"
TOLERANT = settings(
    max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def codes(path: Path) -> list[str]:
    try:
        read_document(path)
    except DiagnosticsError as error:
        assert all(d.place.line >= 1 and d.place.column >= 1 for d in error.diagnostics)
        return [d.code for d in error.diagnostics]
    return []


@TOLERANT
@given(st.binary(max_size=60))
def test_any_bytes_are_findings(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "any.yaml"
    path.write_bytes(content)
    assert codes(path)


@TOLERANT
@given(at=st.integers(0, 10_000), what=st.text(max_size=3), length=st.integers(0, 4))
def test_any_edit_of_a_program_is_a_document_or_findings(
    tmp_path: Path, at: int, what: str, length: int
) -> None:
    text = SEARCHTRACK.read_text("utf-8")
    at %= len(text)
    path = tmp_path / "edited.yaml"
    path.write_text(text[:at] + what + text[at + length :], encoding="utf-8")
    codes(path)


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
@pytest.mark.parametrize("depth", [100, 100_000])
def test_depth_is_bounded(tmp_path: Path, opening: str, depth: int) -> None:
    path = tmp_path / "deep.yaml"
    path.write_text(opening * depth, encoding="utf-8")
    assert codes(path)[-1] in ("CB104", "CB108")


def test_aliases_are_bounded(tmp_path: Path) -> None:
    path = tmp_path / "bomb.yaml"
    lines = ["a0: &a0 [x, x]"] + [
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 10)
    ]
    path.write_text("\n".join(lines), encoding="utf-8")
    assert codes(path) == ["CB108"]


def test_an_alias_of_itself_is_a_finding(tmp_path: Path) -> None:
    path = tmp_path / "loop.yaml"
    path.write_text("kind: &a [*a]\n", encoding="utf-8")
    assert codes(path) == ["CB111"]


def test_a_document_of_another_kind_is_a_finding() -> None:
    with pytest.raises(DiagnosticsError, match="CB201"):
        read(SEARCHTRACK, RobotDocument)


def test_a_directory_and_a_missing_file_are_findings(tmp_path: Path) -> None:
    assert codes(tmp_path) == codes(tmp_path / "none.yaml") == ["CB101"]


def test_a_byte_order_mark_and_windows_lines_are_no_fault(tmp_path: Path) -> None:
    path = tmp_path / "windows.yaml"
    text = SEARCHTRACK.read_text("utf-8").replace("\n", "\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode("utf-8"))
    assert read(path, ProgramDocument).document == read(SEARCHTRACK, ProgramDocument).document


def test_numbers_and_keys_are_what_they_look_like(tmp_path: Path) -> None:
    path = tmp_path / "program.yaml"
    path.write_text(
        "cbdsl: 1\nkind: program\nname: no\nrobot: yes\ncontrollers: {}\nactions: [a]\n"
        "policy: {11: a, 10: a, 0: a, null: a}\nlimits: {transition_time: 1e-3}\n",
        encoding="utf-8",
    )
    document = read(path, ProgramDocument).document
    assert (document.name, document.robot) == ("no", "yes")
    assert list(document.policy) == ["11", "10", "0", "null"]
    assert document.limits.transition_time == 1e-3
