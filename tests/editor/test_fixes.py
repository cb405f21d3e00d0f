"""Corrections, which replace the misspelled name and nothing else."""

from __future__ import annotations

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.editor.fixes import Fix, fix, fixed

TEXT = "a: {potential: sprung, feedback: haed}\nb: sprung sprung\r\n"


def diagnostic(given: str, allowed: str, line: int, column: int, width: int) -> Diagnostic:
    place = Place("own.yaml", line, column, column + width)
    return Diagnostic("CB401", "unknown", place, allowed=(allowed,), given=given)


SPRUNG = diagnostic("sprung", "spring", 1, 16, 6)
HAED = diagnostic("haed", "head", 1, 34, 4)


def test_all_misspellings_of_a_line_are_corrected() -> None:
    assert fixed(TEXT, [SPRUNG, HAED, SPRUNG]) == TEXT.replace("sprung,", "spring,").replace(
        "haed", "head"
    )


def test_name_within_a_longer_text_is_found_in_it() -> None:
    wide = diagnostic("sprung", "spring", 1, 1, 30)
    assert fix(wide, TEXT.splitlines()) == Fix(1, 16, 22, "spring")


def test_uncertain_correction_is_left_out() -> None:
    twice = diagnostic("sprung", "spring", 2, 4, 13)
    elsewhere = diagnostic("gone", "gene", 1, 16, 6)
    nothing_near = diagnostic("sprung", "manipulability", 1, 16, 6)
    beyond = diagnostic("sprung", "spring", 9, 1, 6)
    assert fixed(TEXT, [twice, elsewhere, nothing_near, beyond]) == TEXT
