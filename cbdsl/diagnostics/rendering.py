"""Diagnostics as text: one line that editors understand, the source line, and a caret."""

from __future__ import annotations

from functools import lru_cache

from cbdsl.diagnostics.diagnostic import Diagnostic, Place, Severity
from cbdsl.diagnostics.legible_text import one_line, seen
from cbdsl.diagnostics.lines import lines_of

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
