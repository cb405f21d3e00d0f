"""Bad documents, each with the findings that it names in its last lines."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.cli.ignores import heed_ignores
from cbdsl.errors.diagnostic import Diagnostic
from cbdsl.errors.rendering import render
from cbdsl.yaml_text.library import Library, shipped

BAD = Path(__file__).parent / "bad"
SHIPPED = sorted(
    p for folder in ("robots", "programs") for p in (shipped() / folder).rglob("*.yaml")
)


def text_of(path: Path) -> str:
    return path.read_text("utf-8", errors="replace")  # one of them is no UTF-8


CASES = sorted(path for path in BAD.rglob("*.yaml") if "# finds" in text_of(path))


@pytest.fixture(scope="module")
def session() -> Session:
    """What all cases share: the robots are read once."""
    return Session(Library(BAD))


def findings(path: Path, session: Session) -> list[Diagnostic]:
    return heed_ignores(check_document(path, session=session), [path], session.library)


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_findings(path: Path, session: Session) -> None:
    wanted = re.findall(r"^# finds (.*)$", text_of(path), re.MULTILINE)
    found = []
    for diagnostic in findings(path, session):
        place, message = diagnostic.place, diagnostic.message.replace(f"{BAD}/", "")
        message = re.sub(r"\S*tests/checking/bad/", "", message)
        elsewhere = Path(place.file).name
        where = "" if elsewhere == path.name else f"{elsewhere}:"
        found.append(f"{where}{place.line}:{place.column} {diagnostic.code} {message}")
    assert found == wanted


def test_there_are_enough_cases() -> None:
    assert len(CASES) >= 350


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_caret_stands_inside_its_line(path: Path, session: Session) -> None:
    for diagnostic in findings(path, session):
        text = text_of(Path(diagnostic.place.file))
        lines = render(diagnostic, text).split("\n")
        snippet = [line for line in lines if re.match(r" *\d+ \| ", line)]
        carets = [line for line in lines if re.match(r" +\| \s*\^+$", line)]
        assert len(snippet) == len(carets)
        for source, caret in zip(snippet, carets, strict=True):
            assert len(caret) <= len(source) + 1


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_documents_are_clean(path: Path) -> None:
    assert check_document(path) == []
    assert path.stem == re.search(r"^name: (\w+)$", path.read_text("utf-8"), re.MULTILINE)[1]  # type: ignore[index]
