"""Diagnostics as text: one line that editors understand, the source line, and a caret."""

from __future__ import annotations

from cbdsl.errors.diagnostic import Diagnostic, Place

# No section of a document has more keys.
_MOST_ALLOWED = 16


def render(diagnostic: Diagnostic, source: str | None = None) -> str:
    """A diagnostic as several lines of text.

    Args:
        diagnostic: the finding.
        source: text of its file, for the snippet; without it there is none.
    """
    mark = "" if diagnostic.is_error else " (warning)"
    head = f"{diagnostic.place}: {diagnostic.code}{mark} {diagnostic.message}"
    return "\n".join([head, *_snippet(diagnostic.place, source), *_hints(diagnostic)])


def _snippet(place: Place, source: str | None) -> list[str]:
    lines = (source or "").split("\n")
    if place.line > len(lines) or not lines[place.line - 1].strip():
        return []
    line = lines[place.line - 1].rstrip("\r")
    # Tabs stay tabs, so that the caret stands under its character.
    indent = "".join("\t" if c == "\t" else " " for c in line[: place.column - 1])
    caret = "^" * max(1, min(place.end_column, len(line) + 1) - place.column)
    return [f"{place.line:>5} | {line}", f"      | {indent}{caret}"]


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
