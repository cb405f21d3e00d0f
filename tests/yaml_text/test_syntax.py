"""Slips in YAML are named where they are, not where the parser noticed them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.errors.diagnostic import Diagnostic
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.library import Library, shipped

LINES = {
    path: path.read_text("utf-8").split("\n")
    for folder in ("robots", "programs")
    for path in sorted((shipped() / folder).rglob("*.yaml"))
}
KEY = re.compile(r"\s*(?:- )?[A-Za-z_]\w*(?=:( |$))")
KEYS = [
    (path, number, match.end())
    for path, lines in LINES.items()
    for number, line in enumerate(lines)
    if (match := KEY.match(line))
]
WITH_VALUES = [(p, n, end) for p, n, end in KEYS if len(LINES[p][n]) > end + 1]


def found(path: Path, number: int, line: str) -> list[Diagnostic]:
    """What is found in a shipped document with another line."""
    lines = [*LINES[path][:number], line, *LINES[path][number + 1 :]]
    library = Library(given={path: "\n".join(lines).encode()})
    return check_document(path, session=Session(library))


@settings(max_examples=80)
@given(st.sampled_from(KEYS))
def test_a_missing_colon_is_told_on_its_line(key: tuple[Path, int, int]) -> None:
    path, number, end = key
    line = LINES[path][number]
    (diagnostic,) = found(path, number, line[:end] + line[end + 1 :])
    assert diagnostic.place.line == number + 1
    assert "a ':' is missing after" in diagnostic.message


@settings(max_examples=80)
@given(st.sampled_from(WITH_VALUES))
def test_a_missing_space_is_told_on_its_line(key: tuple[Path, int, int]) -> None:
    path, number, end = key
    line = LINES[path][number]
    (diagnostic,) = found(path, number, line[: end + 1] + line[end + 2 :])
    assert diagnostic.place.line == number + 1
    assert "a space is missing after the ':'" in diagnostic.message


@pytest.mark.parametrize(
    ("text", "place", "problem"),
    [
        ("a: b: c\n", (1, 5), "write 'a: \"b: c\"'"),
        ("- a: see http://x: y\n", (1, 18), "write 'a: \"see http://x: y\"'"),
        ("a: b\n  c: 1\n", (2, 3), "the key 'a' above has a value already"),
        ("a: {x: 1 y: 2}\n", (1, 11), "a ',' is missing before this key"),
        ("a: {x: 1,\n  y: 2\nb: 3\n", (3, 2), "the '}' of the '{' in line 1"),
        ("a: [1, 2\nb: 3\n", (2, 2), "the ']' of the '[' in line 1"),
        ("a: 'x\nb: 3\n", (1, 4), "this quote is never closed"),
    ],
)
def test_a_slip_is_named_with_its_remedy(text: str, place: tuple[int, int], problem: str) -> None:
    with pytest.raises(DiagnosticsError) as error:
        compose(text, "a.yaml")
    (diagnostic,) = error.value.diagnostics
    assert (diagnostic.place.line, diagnostic.place.column) == place
    assert diagnostic.code == "CB104" and problem in diagnostic.message
