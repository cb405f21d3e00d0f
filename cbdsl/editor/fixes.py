"""Corrections of diagnostics with a name that was probably meant."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.lines import line_ends, lines_of


class Fix(NamedTuple):
    """Name on a line, and its replacement.

    Attributes:
        line: Line, from 1.
        column: Column of its first character, from 1.
        end_column: Column after its last character, from 1.
        new: Intended name.
    """

    line: int
    column: int
    end_column: int
    new: str


def fix(diagnostic: Diagnostic, lines: Sequence[str]) -> Fix | None:
    """Return the correction of a diagnostic, or ``None`` without a nearest name or a unique place.

    Args:
        diagnostic: Diagnostic in the lines.
        lines: Lines of its file.
    """
    place, new = diagnostic.place, diagnostic.nearest
    if new is None or not diagnostic.given or not 0 < place.line <= len(lines):
        return None
    stretch = lines[place.line - 1][place.column - 1 : place.end_column - 1]
    offset = stretch.find(diagnostic.given)
    # A name that occurs twice in its place, as in `a ◁ b ◁ a`, may be wrong at either of them.
    if offset < 0 or stretch.find(diagnostic.given, offset + 1) >= 0:
        return None
    column = place.column + offset
    return Fix(place.line, column, column + len(diagnostic.given), new)


def fixed(text: str, diagnostics: Iterable[Diagnostic]) -> str:
    """Return a text with all corrections of its diagnostics, none of which overlap."""
    lines = lines_of(text)
    return replaced(text, {each for diagnostic in diagnostics if (each := fix(diagnostic, lines))})


def replaced(text: str, fixes: Iterable[Fix]) -> str:
    """Return a text with replacements; of two that overlap, the one behind counts."""
    lines, ends = lines_of(text), line_ends(text)
    last = (len(lines) + 1, 0)
    # From the last to the first: a replacement moves only columns that are done.
    for each in sorted(fixes, reverse=True):
        if (each.line, each.end_column) > last:
            continue
        line = lines[each.line - 1]
        lines[each.line - 1] = line[: each.column - 1] + each.new + line[each.end_column - 1 :]
        last = (each.line, each.column)
    return "".join(line + end for line, end in zip(lines, [*ends, ""], strict=True))
