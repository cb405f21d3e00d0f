"""Diagnostics as text."""

from __future__ import annotations

import re

from hypothesis import given
from hypothesis import strategies as st

from cbdsl.diagnostics.diagnostic import Diagnostic, Place, Related, Severity
from cbdsl.diagnostics.text_format import render
from cbdsl.diagnostics.wording import diagnose

PLACE = Place("a.yaml", 2, 9, 13)


def test_caret_stands_under_the_fault() -> None:
    text = render(Diagnostic("CB404", "no 'trak'", PLACE), "one\nactions: trak, x\n")
    assert text.split("\n") == [
        "a.yaml:2:9: CB404 no 'trak'",
        "    2 | actions: trak, x",
        "      |         ^^^^",
    ]


def test_tabs_keep_their_width() -> None:
    text = render(Diagnostic("CB404", "m", Place("a", 1, 3, 4)), "\t\tx")
    assert text.endswith("| \t\t^")


def test_hints_follow_the_message() -> None:
    diagnostic = Diagnostic(
        "CB701",
        "m",
        PLACE,
        Severity.WARNING,
        tuple(f"n{i}" for i in range(18)),
        "n1x",
        related=(Related(PLACE, "here"),),
    )
    assert render(diagnostic).split("\n") == [
        "a.yaml:2:9: CB701 (warning) m",
        "      = did you mean 'n1'?",
        f"      = allowed: {', '.join(f'n{i}' for i in range(16))} and 2 more",
        "      = a.yaml:2:9: here",
    ]


def test_place_beyond_the_text_has_no_snippet() -> None:
    assert "\n" not in render(Diagnostic("CB404", "m", PLACE), "one line")


def test_snippet_of_a_long_line_shows_only_the_surroundings_of_the_fault() -> None:
    line = "x" * 1000 + "BAD" + "y" * 1000
    _, shown, caret = render(Diagnostic("CB404", "m", Place("a", 1, 1001, 1004)), line).split("\n")
    assert len(shown) < 200
    assert shown[caret.index("^") : caret.rindex("^") + 1] == "BAD"


@given(st.text(max_size=30), st.text(max_size=30))
def test_no_text_reaches_the_terminal_as_a_command(name: str, line: str) -> None:
    found = diagnose("CB404", Place("a", 1, 1, 2), name=name)
    printed = render(found, line)
    assert all(c == "\n" or c == "\t" or ord(c) >= 32 for c in printed)
    assert "\x7f" not in printed and "\u202e" not in printed and "\x9b" not in printed


def test_color_adds_only_escape_sequences() -> None:
    found = Diagnostic("CB404", "no 'trak'", PLACE, allowed=("track",), given="trak")
    text = "one\nactions: trak, x\n"
    painted = render(found, text, color=True)
    assert re.sub(r"\033\[[\d;]*m", "", painted) == render(found, text) != painted
