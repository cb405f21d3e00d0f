"""Diagnostics as text: each with its line, a caret, and the allowed names."""

from __future__ import annotations

import os
import sys
from functools import lru_cache

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Diagnostic, Place, Severity
from cbdsl.diagnostics.legible_text import one_line, seen
from cbdsl.diagnostics.lines import lines_of
from cbdsl.diagnostics.validation_report import ValidationReport


def text(report: ValidationReport) -> str:
    """Return the diagnostics and their numbers as text, in colour for a terminal."""
    if not report.diagnostics:
        return f"{count(report.documents, 'document')}, no findings{_skipped(report)}"

    color = _is_colorful()
    lines = [render(d, report.text_of(d.place.file), color) for d in report.diagnostics]
    return "\n".join([*lines, _tally(report)])


def _tally(report: ValidationReport) -> str:
    numbers = {"error": report.errors, "warning": report.warnings, "note": report.notes}
    tally = ", ".join(count(number, noun) for noun, number in numbers.items() if number)
    left_out = f"; {report.left_out} more are left out" if report.left_out else ""
    return tally + left_out + _skipped(report)


def _skipped(report: ValidationReport) -> str:
    """Return the number of unchecked files, after a semicolon; empty if there are none."""
    others = count(report.others, "YAML file")
    skipped = f"; {others} of other tools skipped" if report.others else ""
    folders = count(report.unreadable, "folder")
    unreadable = f"; {folders} cannot be read" if report.unreadable else ""
    return skipped + unreadable


def _is_colorful() -> bool:
    """Return whether the standard output shows colours and the user has not disabled them."""
    wanted = "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    return wanted and sys.stdout.isatty()


# No section of a document has more keys.
_MOST_ALLOWED = 16
# Longer lines are cut to the surroundings of the fault.
_MOST_COLUMNS = 160
_BEFORE = 40

_RESET, _BOLD, _RED, _YELLOW, _CYAN = "\033[0m", "\033[1m", "\033[1;31m", "\033[1;33m", "\033[36m"
_TINTS = {Severity.ERROR: _RED, Severity.WARNING: _YELLOW, Severity.NOTE: _CYAN}


def render(diagnostic: Diagnostic, source: str | None = None, color: bool = False) -> str:
    """Return a diagnostic as several lines of text.

    Args:
        diagnostic: Diagnostic to render.
        source: Text of its file for the snippet; ``None`` for no snippet.
        color: True to mark parts with a terminal's escape sequences.
    """
    tint = _TINTS[diagnostic.severity]
    mark = "" if diagnostic.is_error else f" ({diagnostic.severity.value})"
    place = _paint(str(diagnostic.place), _BOLD, color)
    code = _paint(f"{diagnostic.code}{mark}", tint, color)
    snippet = _snippet(diagnostic.place, source, tint if color else "")
    hints = [_paint(one_line(hint), _CYAN, color) for hint in _hints(diagnostic)]
    return "\n".join([f"{place}: {code} {one_line(diagnostic.message)}", *snippet, *hints])


def _paint(text: str, tint: str, color: bool) -> str:
    return f"{tint}{text}{_RESET}" if color else text


@lru_cache(maxsize=2)
def _lines(source: str) -> list[str]:
    """Return the lines of a text, split once for all its diagnostics."""
    return lines_of(source)


def _snippet(place: Place, source: str | None, tint: str) -> list[str]:
    lines = _lines(source or "")
    if place.line > len(lines) or not lines[place.line - 1].strip():
        return []
    # A terminal obeys some of the characters that a damaged file may hold.
    line = seen(lines[place.line - 1], lambda unseen: "\t" if unseen == "\t" else "\ufffd")
    line, column = _window(line, place.column)
    # Tabs stay tabs, so that the caret stands under its character.
    indent = "".join("\t" if c == "\t" else " " for c in line[: column - 1])
    # A missing value has an empty place, and a place may exceed the visible part of its line.
    width = max(1, min(place.end_column - place.column, len(line) + 1 - column))
    caret = _paint("^" * width, tint, bool(tint))
    return [f"{place.line:>5} | {line}", f"      | {indent}{caret}"]


def _window(line: str, column: int) -> tuple[str, int]:
    """Return the visible part of a line, and the column in it."""
    if len(line) <= _MOST_COLUMNS:
        return line, column
    start = max(0, column - 1 - _BEFORE)
    end = start + _MOST_COLUMNS
    before, after = "…" if start else "", "…" if end < len(line) else ""
    return f"{before}{line[start:end]}{after}", column - start + len(before)


def _hints(diagnostic: Diagnostic) -> list[str]:
    hints = []
    if diagnostic.nearest is not None:
        hints.append(f"did you mean '{diagnostic.nearest}'?")
    if diagnostic.allowed:
        shown = ", ".join(diagnostic.allowed[:_MOST_ALLOWED])
        more = len(diagnostic.allowed) - _MOST_ALLOWED
        hints.append(f"allowed: {shown}" + (f" and {more} more" if more > 0 else ""))
    hints += [f"{related.place}: {related.message}" for related in diagnostic.related]
    return [f"      = {hint}" for hint in hints]
