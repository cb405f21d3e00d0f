"""Corrections of findings that name what was probably meant."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from cbdsl.errors.diagnostic import Diagnostic
from cbdsl.errors.lines import line_ends, lines_of


class Fix(NamedTuple):
    """A name on a line, and what takes its place.

    Attributes:
        line: from 1.
        column: its first character, from 1.
        end_column: the character after its last.
        new: the name that was meant.
    """

    line: int
    column: int
    end_column: int
    new: str


def fix(finding: Diagnostic, lines: Sequence[str]) -> Fix | None:
    """The correction of a finding, or ``None`` where there is no nearest name or no such text.

    Args:
        finding: in the lines.
        lines: the text of its file.
    """
    place, new = finding.place, finding.nearest
    if new is None or not finding.given or not 0 < place.line <= len(lines):
        return None
    stretch = lines[place.line - 1][place.column - 1 : place.end_column - 1]
    offset = stretch.find(finding.given)
    if offset < 0 or stretch.find(finding.given, offset + 1) >= 0:
        return None
    column = place.column + offset
    return Fix(place.line, column, column + len(finding.given), new)


def fixed(text: str, findings: Iterable[Diagnostic]) -> str:
    """Return a text with all corrections of its findings, none of which overlap."""
    lines = lines_of(text)
    ends = line_ends(text)
    fixes = sorted({each for finding in findings if (each := fix(finding, lines))}, reverse=True)
    last = (len(lines) + 1, 0)
    for each in fixes:
        if (each.line, each.end_column) > last:
            continue
        line = lines[each.line - 1]
        lines[each.line - 1] = line[: each.column - 1] + each.new + line[each.end_column - 1 :]
        last = (each.line, each.column)
    return "".join(line + end for line, end in zip(lines, [*ends, ""], strict=True))
