"""Formatted text: one layout for every input, with the same values and comments."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.documents.document import Document
from cbdsl.yaml_text.composer import LOADER, YamlSyntaxError
from cbdsl.yaml_text.formatter import comments, formatted
from cbdsl.yaml_text.reader import formatted_text, read_sound_parts
from tests.conftest import ROOT

SHIPPED = sorted(
    file for name in ("robots", "programs", "knowledge") for file in (ROOT / name).rglob("*.yaml")
)
SHORT = [file for file in SHIPPED if file.stat().st_size < 8_000]
PIECES = (
    *(" ", "\n", "  ", "#", " # x", "- ", ":", ",", "{", "}", "[", "]", "'", "\n\n", "|", ""),
    *("\u2028", "\u2029", "\x85", "\r", "\r\n", "\ufeff", '"', "&a ", "*a", "? ", "\t"),
    *("!x ", "%", "---\n", "...\n", ">-\n", "~", "\\"),
)
UNEVEN = """\
# first


a:   {b:1 m,c :  [ 1,2 ], "d":3}   # behind
e:
      # about f
      f:  1
      g:
          -   h : 1
              i: 2
          # about the next
          -   [1,
               2]


      j: >-
            words
              and more

            end
k:
- one   two
-   two
l: "a
    b

    c"
"""
EVEN = """\
# first

a: {b:1 m, c: [1, 2], "d": 3}   # behind
e:
  # about f
  f: 1
  g:
    - h: 1
      i: 2
    # about the next
    - [1,
       2]

  j: >-
    words
      and more

    end
k:
- one   two
- two
l: "a
  b

  c"
"""


def values(text: str) -> list[tuple[object, ...]]:
    return [
        (type(event), getattr(event, "value", None)) for event in yaml.parse(text, Loader=LOADER)
    ]


def test_formatter_aligns_uneven_spaces() -> None:
    assert formatted(UNEVEN) == EVEN
    assert formatted(EVEN) == EVEN
    assert values(EVEN) == values(UNEVEN)
    assert comments(UNEVEN) == comments(EVEN) == [
        "# first", "# behind", "# about f", "# about the next",
    ]  # fmt: skip


@pytest.mark.parametrize("file", SHIPPED, ids=[file.stem for file in SHIPPED])
def test_shipped_documents_are_formatted(file: Path) -> None:
    assert formatted(file.read_text("utf-8")) == file.read_text("utf-8")


@pytest.mark.parametrize("ending", ["\r\n", "\r"])
def test_formatter_writes_one_kind_of_line_end(ending: str) -> None:
    assert formatted(EVEN.replace("\n", ending)) == EVEN
    assert formatted("\ufeff" + EVEN.rstrip("\n")) == EVEN


@pytest.mark.parametrize(
    "text",
    [
        "a:  |2\n    b\n",  # has an explicit indentation
        "? a\n:   b\n",
        "a:   !!str 1\n",
    ],
)
def test_formatter_leaves_texts_with_their_own_layout(text: str) -> None:
    assert formatted(text) == text


@pytest.mark.parametrize(
    "text",
    ["a: [1\n", "a: 'b\n", "a: b: c\n", "\t- a\n", "[- a]\n", "a: [- b]\n", "a: !!str [- b]\n"],
)
def test_text_that_is_no_yaml_is_refused(text: str) -> None:
    with pytest.raises(YamlSyntaxError):
        formatted(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "\n\n",
        "# only\n",
        "a\n",
        "- a\n-  b\n",
        "{a:   1}\n",
        "[]",
        "a:   &b {c:  1}\nd:  *b\n*b : 1",
    ],
)
def test_formatter_is_idempotent_on_small_texts(text: str) -> None:
    once = formatted(text)
    assert formatted(once) == once and values(once) == values(text)
    assert comments(once) == comments(text)


@pytest.mark.parametrize("separator", ["\u2028", "\u2029", "\x85"])
def test_line_separator_within_a_value_stays(separator: str) -> None:
    for text in (f"a: [1,  2{separator}3]\n", f'a:   "x{separator}y"\n'):
        assert values(formatted(text)) == values(text)


def disordered(text: str, rng: random.Random) -> str:
    """Return the same document with other columns, spaces in brackets and empty lines."""
    times = rng.choice([1, 2, 3])
    lines = []
    for line in text.splitlines():
        indent = len(line) - len(line.lstrip())
        body, hash_, comment = line.lstrip().partition(" #")
        if re.match(r"[\w.-]+: [\[{][^\"'#]*[\]}]$", body) and rng.random() < 0.5:
            body = re.sub(r"([\[{,])(?=[^ ]| )", lambda m: m[0] + " " * rng.randrange(3), body)
            body = re.sub(r"(?=[\]}])", lambda m: " " * rng.randrange(2), body)
        body = re.sub(r"^(- )+", lambda m: m[0].replace("- ", "-" + " " * (2 * times - 1)), body)
        lines.append(" " * indent * times + body + hash_ + comment + " " * rng.randrange(2))
        if not body.strip() and rng.random() < 0.5:
            lines.append("")
    return "\n".join(lines) + "\n" * rng.randrange(3)


@settings(max_examples=200)
@given(st.sampled_from(SHORT), st.integers(0, 10**9))
def test_document_in_disorder_is_put_in_order(file: Path, seed: int) -> None:
    text = file.read_text("utf-8")
    uneven = disordered(text, random.Random(seed))
    if values(uneven) != values(text):
        return  # an empty line or a trailing space of a text over several lines
    result = formatted(uneven)
    assert values(result) == values(text)
    assert comments(result) == comments(uneven)
    assert formatted(result) == result
    assert not re.search(r"[ \t]$|\n\n\n", result, re.MULTILINE)
    if not re.search(r"^[^#]*[\[{,]( *#.*)?$", text, re.MULTILINE):
        assert result == text  # brackets over several lines keep their columns


@settings(max_examples=200)
@given(st.sampled_from(SHORT), st.integers(0, 10**9))
def test_any_edit_that_is_yaml_keeps_its_values_and_comments(file: Path, seed: int) -> None:
    text, rng = list(file.read_text("utf-8")), random.Random(seed)
    for _ in range(rng.randrange(1, 6)):
        place = rng.randrange(len(text))
        text[place : place + rng.randrange(3)] = rng.choice(PIECES)
    edited = "".join(text)
    try:
        before = values(edited)
    except yaml.YAMLError:
        return
    try:
        result = formatted(edited)
    except YamlSyntaxError:
        return  # the two scanners accept different texts
    assert values(result) == before
    assert comments(result) == comments(edited)
    assert formatted(result) == result


def diagnostics(text: str) -> list[tuple[str, str]]:
    """Return the reader's diagnostics in a text, without places."""
    try:
        faults = read_sound_parts(Path("a.yaml"), Document, text).diagnostics
    except DiagnosticsError as error:
        faults = error.diagnostics
    return [(each.code, each.message) for each in faults]


@settings(max_examples=200)
@given(st.sampled_from(SHORT), st.integers(0, 10**9))
def test_formatted_text_has_the_values_and_findings_of_the_text(file: Path, seed: int) -> None:
    text, rng = list(file.read_text("utf-8")), random.Random(seed)
    for _ in range(rng.randrange(1, 4)):
        place = rng.randrange(len(text))
        text[place : place + rng.randrange(2)] = rng.choice(
            ["1,5", "1,5 rad/s", ",", ", ", "{a: 1,2}", "[1,2]", ":", "1 ,5", "{1,5}", "  ", "- "]
        )
    edited = "".join(text)
    try:
        result = formatted_text(edited, "a.yaml")
    except DiagnosticsError:
        return
    assert values(result) == values(edited)
    assert diagnostics(result) == diagnostics(edited)
