"""Diagnostics as text."""

from __future__ import annotations

from cbdsl.errors.diagnostic import Diagnostic, Place, Related, Severity
from cbdsl.errors.rendering import render

PLACE = Place("a.yaml", 2, 9, 13)


def test_the_caret_stands_under_the_fault() -> None:
    text = render(Diagnostic("CB404", "no 'trak'", PLACE), "one\nactions: trak, x\n")
    assert text.split("\n") == [
        "a.yaml:2:9: CB404 no 'trak'",
        "    2 | actions: trak, x",
        "      |         ^^^^",
    ]


def test_tabs_keep_their_width() -> None:
    text = render(Diagnostic("CB404", "m", Place("a", 1, 3, 4)), "\t\tx")
    assert text.endswith("| \t\t^")


def test_hints_follow() -> None:
    diagnostic = Diagnostic(
        "CB701",
        "m",
        PLACE,
        Severity.WARNING,
        tuple(f"n{i}" for i in range(18)),
        "n1",
        (Related(PLACE, "here"),),
    )
    assert render(diagnostic).split("\n") == [
        "a.yaml:2:9: CB701 (warning) m",
        "      = did you mean 'n1'?",
        f"      = allowed: {', '.join(f'n{i}' for i in range(16))} and 2 more",
        "      = a.yaml:2:9: here",
    ]


def test_a_place_beyond_the_text_has_no_snippet() -> None:
    assert "\n" not in render(Diagnostic("CB404", "m", PLACE), "one line")
