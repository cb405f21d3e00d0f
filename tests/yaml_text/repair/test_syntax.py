"""Mistakes in YAML, reported where they are, not where the parser noticed them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.yaml_text.library import Library, shipped
from cbdsl.yaml_text.repair.repair import mend

LINES = {
    path: path.read_text("utf-8").split("\n")
    for folder in ("robots", "programs")
    for path in sorted((shipped() / folder).rglob("*.yaml"))
}
KEY = re.compile(r"\s*(?:- )?[A-Za-z_]\w*(?=:( |$))")
FOLDED = re.compile(r"\s*[a-z]+: >-$")


def in_folded(lines: list[str], number: int) -> bool:
    """Return whether a line is part of a folded text, where a colon is an ordinary character."""
    while number and lines[number].startswith("  "):
        number -= 1
        if FOLDED.match(lines[number]):
            return True
    return False


KEYS = [
    (path, number, match.end())
    for path, lines in LINES.items()
    for number, line in enumerate(lines)
    if (match := KEY.match(line)) and not in_folded(lines, number)
]
WITH_VALUES = [(p, n, end) for p, n, end in KEYS if len(LINES[p][n]) > end + 1]


def found(path: Path, number: int, line: str) -> list[Diagnostic]:
    """Return the diagnostics of a shipped document with one line replaced."""
    lines = [*LINES[path][:number], line, *LINES[path][number + 1 :]]
    library = Library(given={path: "\n".join(lines).encode()})
    return check_document(path, session=Session(library))


@given(st.sampled_from(KEYS))
def test_missing_colon_is_reported_on_its_line(key: tuple[Path, int, int]) -> None:
    path, number, end = key
    line = LINES[path][number]
    (diagnostic,) = found(path, number, line[:end] + line[end + 1 :])
    assert diagnostic.place.line == number + 1
    assert "a ':' is missing after" in diagnostic.message


@given(st.sampled_from(WITH_VALUES))
def test_missing_space_is_reported_on_its_line(key: tuple[Path, int, int]) -> None:
    path, number, end = key
    line = LINES[path][number]
    (diagnostic,) = found(path, number, line[: end + 1] + line[end + 2 :])
    assert diagnostic.place.line == number + 1
    assert "a space is missing after the ':'" in diagnostic.message


def corrections(text: str) -> list[Diagnostic]:
    """Return the diagnostics of a YAML text, with or without a successful repair."""
    try:
        return list(mend(text, "a.yaml").diagnostics)
    except DiagnosticsError as error:
        return list(error.diagnostics)


NOT_YAML = [
    ("a: b: c\n", (1, 5), "write 'a: \"b: c\"'"),
    ("- a: see http://x: y\n", (1, 18), "write 'a: \"see http://x: y\"'"),
    ("a: {x: 1 y: 2}\n", (1, 11), "a ',' is missing before this key"),
    ("a: {x: 1; y: 2}\n", (1, 12), "parted by ',', not by ';'"),
    ("a: {x: 1,\n  y: 2\nb: 3\n", (1, 4), "this '{' is never closed; a '}' is missing"),
    ("a: [1, 2\nb: 3\n", (1, 4), "this '[' is never closed; a ']' is missing"),
    ("a: [1, 2}\n", (1, 9), "this '}' does not close the '[' in line 1; write ']'"),
    ("a: [1, 2]]\nb: 1\n", (1, 10), "unmatched ']'"),
    ("a: [1, 2],\nb: 1\n", (1, 10), "leave out the ',' at the end"),
    ("a: [1, 2] deg\nb: 1\n", (1, 11), "'deg' cannot follow the ']'"),
    ("a: [1,, 2]\n", (1, 7), "a value is missing before this ','"),
    ("a: 'x\nb: 3\n", (1, 4), "this quote is never closed"),
    ("a: 1\nb = 2\nc: 3\n", (2, 2), "write 'b: 2', without '='"),
    ("a: 1\nb -> 2\nc: 3\n", (2, 2), "write 'b: 2', without '->'"),
    ("a: 1\n// b\nc: 3\n", (2, 1), "comments begin with '#', not with '//'"),
    ("a: 1\n% b\nc: 3\n", (2, 1), "comments begin with '#', not with '%'"),
    ("a: (b: c)\n", (1, 4), "write 'a: {b: c}'"),
    ("a: b c: d\n", (1, 7), "two keys are in one line"),
    ("a:\n  - b\n  -c\nd: 1\n", (3, 3), "write '- c'"),
    ("a: 1\n```\n", (2, 1), "a block of code"),
    ("a: 1\n...\nb: 2\n", (2, 1), "'...' ends the document"),
    ("a: {b: ${c}}\n", (1, 9), "without braces, as $name"),
]
OUT_OF_LINE = [
    ("a: b\n  c: 1\n", (2, 3), "by 2 spaces; indent it by 0 spaces, like 'a' in line 1"),
    ("a:\n  b: 1\n   c: 1\n  d: 1\n", (3, 4), "by 2 spaces, like 'b' in line 2"),
    ("a:\n  b: 1\n c: 1\n  d: 1\n", (3, 2), "by 2 spaces, like 'b' in line 2"),
    ("a:\n   b: 1\n  c: 1\n  d: 1\n", (2, 4), "by 2 spaces, like 'c' in line 3"),
    ("a:\n b: 1\n  c: 1\n  d: 1\n", (2, 2), "by 2 spaces, like 'c' in line 3"),
    ("a:\n  b: 1\nc: 1\n  d: 1\n", (3, 1), "by 2 spaces, like 'b' in line 2"),
    ("a:\n  - b\n - c\n  - d\n", (3, 2), "by 2 spaces, like 'b' in line 2"),
    ("a:\n  - b\n  c:\n", (3, 3), "begin it with '- '"),
    ("a:\n  b: 1\n  - c: 1\n", (3, 3), "leave the '-' out"),
    ("a:\n  b:\n  c: 1\n    d: 1\n", (3, 3), "it belongs to 'b' in line 2"),
    ("a: >-\n  words\n b: 1\nc: 1\n", (3, 2), "by 0 spaces, like 'a' in line 1"),
]
UNQUOTED = [
    ("a:\n  *10: b\n", (2, 3), "write '*10'"),
    ("a:\n  **1: b\n  *: c\n", (2, 3), "write '**1'"),
    ("a:\n  [0, *, *]: b\n", (2, 3), "write '0**'"),
    ("a: @b\n", (1, 4), "write '@b'"),
    ("a: `b`\n", (1, 4), "write 'b'"),
    ("a: &b\n", (1, 4), "write '&b'"),
    ("a: {b: here + [0 cm, 1 cm], c: d}\n", (1, 8), 'write "here + [0 cm, 1 cm]"'),
    ("a: {b: 1 m, c: stereo.red - [1 cm]}\n", (1, 16), 'write "stereo.red - [1 cm]"'),
]
LOOK_ALIKE = [
    ("a: \u221244 cm\n", (1, 4), "(U+2212, minus sign) looks like another character"),
    ("a: \u20131.5\n", (1, 4), "write '-1.5'"),
    ("a: \uff12\uff15\n", (1, 4), "write '25'"),
    ("a: 25\xa0cm\n", (1, 4), "U+00A0 (no-break space)"),
    ("a: 90\xb0\n", (1, 4), "write '90 deg'"),
    ("a: 2 m/s\xb2\n", (1, 4), "write '2 m/s^2'"),
    ("a: s\u0440ring\n", (1, 4), "write 'spring'"),
    ("s\u0440ring: 1\n", (1, 1), "write 'spring'"),
    ("X\u2212*: 1\n", (1, 1), "write 'X-*'"),
    ("\u201cX*\u201d: 1\n", (1, 1), "write 'X*'"),
    ("a:\n\xa0\xa0b: 1\n  c: 1\n", (2, 1), "write 'b: 1'"),
    ("a:\n  b:\xa01\n  c: 1\n", (2, 5), "write 'b: 1'"),
    ("a:\n  b\uff1a 1\n  c: 1\n", (2, 4), "write 'b: 1'"),
    ("a:\n  - b\n  \u2022 c\nd: 1\n", (3, 3), "write '- c'"),
]
CASES = [
    *(("CB104", *case) for case in NOT_YAML),
    *(("CB121", *case) for case in OUT_OF_LINE),
    *(("CB124", *case) for case in UNQUOTED),
    *(("CB123", *case) for case in LOOK_ALIKE),
]


@pytest.mark.parametrize(("code", "text", "place", "problem"), CASES)
def test_syntax_error_is_named_with_its_remedy(
    code: str, text: str, place: tuple[int, int], problem: str
) -> None:
    found = corrections(text)
    assert {diagnostic.code for diagnostic in found} == {code}
    assert (found[0].place.line, found[0].place.column) == place
    assert problem in found[0].message


@pytest.mark.parametrize(
    "text",
    [
        "a: \u201cwords in quotes\u201d\n",
        "a: 5 \u2013 6 words\n",
        "a: >-\n  \u2022 one\n  \u2022 two\n",
        "a: \u0441\u043e\u0440\n",
        "a: '\u22121'\n",
        "a: |\n   a line\n  # another\n",
    ],
)
def test_words_may_have_any_character(text: str) -> None:
    assert corrections(text) == []


def test_corrected_syntax_hides_no_other_diagnostic() -> None:
    text = "a:\n  *1: b\n  c: yes\n   d: 1\n  e: \u22121\n  f: no\n"
    assert [d.code for d in corrections(text)] == ["CB121", "CB124", "CB114", "CB123", "CB114"]
    text = "a: {b: here + [0 cm], c: yes}\nd: {e: here + [1 cm]}\n"
    assert sorted(d.code for d in corrections(text)) == ["CB114", "CB124", "CB124"]


@pytest.mark.parametrize("ours", ["b: 1\n", ""])
@pytest.mark.parametrize("theirs", ["b: 2\n", ""])
def test_merge_conflict_is_one_finding(ours: str, theirs: str) -> None:
    conflict = f"<<<<<<< a\n{ours}=======\n{theirs}>>>>>>> b\n"
    composed = mend(f"a: 1\n{conflict}c: yes\n", "a.yaml")
    assert [d.code for d in composed.diagnostics] == ["CB122", "CB114"]
    assert composed.diagnostics[0].place.line == 2
