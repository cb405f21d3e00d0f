"""Arbitrary files: each is a document or a located diagnostic, never another exception."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cbdsl.checking.document import check_document
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
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


@pytest.mark.parametrize(("missing", "near"), [("bow", None), ("po", "pol"), ("posture", None)])
def test_common_suffix_of_files_makes_no_name_similar(
    missing: str, near: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pol.yaml").touch()
    with pytest.raises(DiagnosticsError) as told:
        read_document(Path(f"{missing}.yaml"))
    assert told.value.diagnostics[0].nearest == (near and f"{near}.yaml")


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
@pytest.mark.parametrize("depth", [100, 100_000])
def test_depth_is_bounded(tmp_path: Path, opening: str, depth: int) -> None:
    path = tmp_path / "deep.yaml"
    path.write_text(opening * depth, encoding="utf-8")
    assert codes(path)[-1] in ("CB104", "CB108", "CB119")


def test_aliases_are_bounded(tmp_path: Path) -> None:
    path = tmp_path / "bomb.yaml"
    lines = ["a0: &a0 [x, x]"] + [
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 10)
    ]
    path.write_text("\n".join(lines), encoding="utf-8")
    assert codes(path) == ["CB108"]


MERGING = """cbdsl: 1
kind: program
name: own
robot: dexter
controllers:
  one: &one
    {potential: spring, reference: right_arm.ready, feedback: right_arm, effector: right_arm}
  two: {<<: *one, reference: right_arm.home}
  three: {<<: [{gain: 3 /s}, *one], gain: 2 /s}
actions: [one, two, three]
"""


def test_merge_key_adds_the_entries_that_are_not_written(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(MERGING, encoding="utf-8")
    controllers = read(path, ProgramDocument).document.controllers
    told = {name: (each.reference, each.gain) for name, each in controllers.items()}
    assert told == {
        "one": ("right_arm.ready", None),
        "two": ("right_arm.home", None),
        "three": ("right_arm.ready", 2.0),
    }
    assert [diagnostic.code for diagnostic in check_document(path)] == []


@pytest.mark.parametrize("value", ["3", "[3]", "text", "~"])
def test_merge_key_without_a_mapping_is_one_finding(value: str, tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(MERGING.replace("{<<: *one, ", f"{{<<: {value}, "), encoding="utf-8")
    assert codes(path) == ["CB125"]


def test_quoted_merge_key_is_an_ordinary_key(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(MERGING.replace("{<<: *one, ", '{"<<": *one, '), encoding="utf-8")
    assert sorted(codes(path)) == ["CB202", *["CB203"] * 3]


def test_merge_keys_are_bounded(tmp_path: Path) -> None:
    lines = ["a0: &a0 {x: {y: 1}}"] + [
        f"a{i}: &a{i} {{p: *a{i - 1}, q: *a{i - 1}, <<: *a{i - 1}}}" for i in range(1, 40)
    ]
    path = tmp_path / "bomb.yaml"
    path.write_text("\n".join(lines), encoding="utf-8")
    assert codes(path) == ["CB108"]


def test_alias_of_itself_is_a_finding(tmp_path: Path) -> None:
    path = tmp_path / "loop.yaml"
    path.write_text("kind: &a [*a]\n", encoding="utf-8")
    assert codes(path) == ["CB111"]


def test_document_of_another_kind_is_a_finding() -> None:
    with pytest.raises(DiagnosticsError, match="CB201"):
        read(SEARCHTRACK, RobotDocument)


def test_directory_and_a_missing_file_are_findings(tmp_path: Path) -> None:
    assert codes(tmp_path) == codes(tmp_path / "none.yaml") == ["CB101"]


def test_byte_order_mark_and_windows_lines_are_no_fault(tmp_path: Path) -> None:
    path = tmp_path / "windows.yaml"
    text = SEARCHTRACK.read_text("utf-8").replace("\n", "\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode("utf-8"))
    assert read(path, ProgramDocument).document == read(SEARCHTRACK, ProgramDocument).document


def test_unquoted_names_and_states_stay_texts(tmp_path: Path) -> None:
    path = tmp_path / "program.yaml"
    path.write_text(
        "cbdsl: 1\nkind: program\nname: y\nrobot: n\ncontrollers: {}\nactions: [a]\n"
        "policy: {11: a, 10: a, 0: a, null: a}\nlimits: {transition_time: 1e-3}\n",
        encoding="utf-8",
    )
    document = read(path, ProgramDocument).document
    assert (document.name, document.robot) == ("y", "n")
    assert list(document.policy) == ["11", "10", "0", "null"]
    assert document.limits.transition_time == 1e-3


@pytest.mark.parametrize(
    ("text", "code"),
    [
        *((word, "CB114") for word in ("NO", "yes", "On", "off")),
        *((time, "CB115") for time in ("12:30:45", "1:30", "190:20:30.15")),
        *((number, "CB116") for number in ("0x1F", "0o17", "0b101", "1_000", "-1_0.5")),
        *((number, "CB110") for number in ("0755", "-012")),
        *((number, "CB109") for number in (".inf", "-.INF", ".NaN")),
        *((number, "CB120") for number in ("9007199254740993", "9" * 5000, "1e999", "1e-999")),
    ],
)
def test_value_with_another_meaning_in_yaml_1_1_is_refused_unless_quoted(
    tmp_path: Path, text: str, code: str
) -> None:
    path = tmp_path / "trap.yaml"
    path.write_text(f"kind: stage\ndescription: {text}\n", encoding="utf-8")
    assert codes(path)[0] == code
    path.write_text(f'description: "{text}"\nkind: policy\n', encoding="utf-8")
    assert code not in codes(path)


@pytest.mark.parametrize("text", ["1e-3", "0.0", "0e0", "9007199254740992", "y", "n", "a:b", "_1"])
def test_value_with_one_meaning_is_accepted(tmp_path: Path, text: str) -> None:
    path = tmp_path / "sound.yaml"
    path.write_text(f"description: {text}\n", encoding="utf-8")
    assert codes(path) == ["CB203"]  # there is no kind


@pytest.mark.parametrize("line_break", ["\r", "\x85", "\u2028", "\r\n"])
def test_lines_are_counted_as_the_parser_counts_them(tmp_path: Path, line_break: str) -> None:
    path = tmp_path / "breaks.yaml"
    text = (
        SEARCHTRACK.read_text("utf-8")
        .replace("actions: [", "actions: [trak ◁ , ")
        .replace("\n", line_break)
    )
    path.write_bytes(text.encode("utf-8"))
    places = [d.place for d in check_document(path)]
    written = re.split("\r\n|[\n\r\x85\u2028]", text)
    assert places
    assert all(place.line <= len(written) for place in places)


def test_document_has_an_upper_size(tmp_path: Path) -> None:
    path = tmp_path / "large.yaml"
    for text in ("#" * 1_000_000, "[" + "a," * 30_000 + "]", "a: [" + "1," * 2001 + "]"):
        path.write_text(text, encoding="utf-8")
        assert codes(path) == ["CB108"]
