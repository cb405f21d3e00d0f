"""Renaming: it adds no diagnostics, and the old name is gone."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

import cbdsl
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.coloring import colored_words
from cbdsl.editor.cursor import cursor
from cbdsl.editor.rename import Renaming, renaming
from tests.conftest import ROOT

#: Learned policies and schemas record a digest of their program, which renaming changes.
#: A comment of `reach` suppresses the note on actions that learning alone chooses.
EXPECTED = {"CB622", "CB634", "CB732"}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to a copy of all shipped documents."""
    for name in ("robots", "programs", "knowledge"):
        shutil.copytree(ROOT / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rename(here: Path, file: str, mark: str, new: str) -> Renaming | None:
    """Rename the name after a mark, in all files."""
    buffers, path = Buffers(here), here / file
    text = path.read_text("utf-8")
    place = text.index(mark) + len(mark)
    line = text.count("\n", 0, place)
    at = cursor(text.splitlines(), line, place - text.rfind("\n", 0, place) - 1)
    named = renaming(buffers, path, at)
    for each, spots in (named.spots if named else {}).items():
        lines = each.read_text("utf-8").splitlines(keepends=True)
        for number, start, end in sorted(spots, reverse=True):
            assert lines[number][start:end] == named.old
            lines[number] = lines[number][:start] + new + lines[number][end:]
        each.write_text("".join(lines), encoding="utf-8")
    if named and named.moved:
        named.moved.rename(named.moved.with_stem(new))
    return named


def diagnostics(folder: str) -> dict[str, int]:
    """Return the number of diagnostics by code in a folder's documents."""
    files = sorted(Path(folder).rglob("*.yaml"))
    codes = [each.code for each in cbdsl.check(*files)]
    return {code: codes.count(code) for code in codes}


def _unexpected(counts: dict[str, int]) -> dict[str, int]:
    return {code: count for code, count in counts.items() if code not in EXPECTED}


def test_controller_is_renamed_in_its_program_and_its_policies(here: Path) -> None:
    named = rename(here, "programs/searchtrack.yaml", "search ◁ ", "follow")
    assert named is not None and named.old == "track"
    files = {path.relative_to(here).as_posix() for path in named.spots}
    assert files == {
        "programs/searchtrack.yaml",
        "knowledge/policies/searchtrack.yaml",
        "knowledge/policies/searchtrack_table.yaml",
    }
    for file in files:
        code = re.sub(r"#.*", "", (here / file).read_text("utf-8"))
        within = [line for line in code.splitlines() if "description" not in line]
        assert not [line for line in within if re.search(r"\btrack\b", line)], file
    assert {*diagnostics(".")} <= EXPECTED


def test_parameter_is_renamed_in_its_program(here: Path) -> None:
    named = rename(here, "programs/posture.yaml", "effector: $", "limb")
    assert named is not None and named.old == "arm"
    text = (here / "programs/posture.yaml").read_text("utf-8")
    assert "$arm" not in text and "$limb" in text and re.search(r"\blimb:", text)
    assert cbdsl.check(Path("programs/posture.yaml")) == []


@pytest.mark.parametrize("mark", ["effector: $", "roles: {", "other than ", " on "])
def test_role_is_renamed_in_its_program_with_its_relations(here: Path, mark: str) -> None:
    roles = "{arm: effector of position, hand: effector of configuration on arm, "
    roles += "second: arm other than arm}"
    (here / "programs/pair.yaml").write_text(
        f"cbdsl: 1\nkind: program\nname: pair\nroles: {roles}\n"
        "controllers:\n"
        "  ready: {potential: spring, reference: $arm.ready, feedback: $arm, effector: $arm}\n"
        "actions: [ready]\npolicy: {X: ready}\n",
        "utf-8",
    )
    named = rename(here, "programs/pair.yaml", mark, "limb")
    assert named is not None and named.old == "arm" and len(named.spots) == 1
    text = (here / "programs/pair.yaml").read_text("utf-8")
    assert text.count("limb") == 7 and not re.search(r"\barm\b", text)


@pytest.mark.parametrize(
    ("file", "mark", "new"),
    [
        ("programs/searchtrack.yaml", "stage: ", "my_table"),
        ("programs/stages/table_right.yaml", "name: ", "my_table"),
        ("programs/visualinspect.yaml", "policy: ", "my_policy"),
        ("programs/visualinspect.yaml", "{program: ", "my_reach"),
        ("programs/stages/sixaxis_bin.yaml", "robot: ", "my_arm"),
    ],
)
def test_document_is_renamed_in_all_documents_that_name_it(
    here: Path, file: str, mark: str, new: str
) -> None:
    before = {code: count for code, count in diagnostics(".").items() if code not in EXPECTED}
    named = rename(here, file, mark, new)
    assert named is not None and named.moved is not None and len(named.spots) > 1
    assert not named.moved.exists() and named.moved.with_stem(new).exists()
    after = diagnostics(".")
    assert _unexpected(after) == _unexpected(before)


@pytest.mark.parametrize(
    ("file", "mark"),
    [
        ("programs/searchtrack.yaml", "potential: "),
        ("programs/searchtrack.yaml", "feedback: "),
        ("programs/searchtrack.yaml", "descr"),
        ("programs/searchtrack.yaml", "cbdsl: "),
    ],
)
def test_name_without_a_declaration_is_not_renamed(here: Path, file: str, mark: str) -> None:
    assert rename(here, file, mark, "other") is None


def test_words_of_compositions_have_kinds(here: Path) -> None:
    path = here / "programs" / "reachtouch.yaml"
    lines = path.read_text("utf-8").splitlines()
    words = list(colored_words(Buffers(here), path))
    kinds = {(lines[w.line][w.start : w.end], w.kind) for w in words}
    assert {
        ("◁", "operator"), ("reach", "function"), ("touch", "function"), ("spring", "type"),
        ("searchtrack", "namespace"), ("$arm", "parameter"),
    } <= kinds  # fmt: skip
    assert ("program", "function") not in kinds
    assert words == sorted(words)
