"""Merge conflicts and diffs: two versions of the same lines in one text.

If git cannot merge two versions, it writes both between markers. A diff writes ``-`` in front of
old lines and ``+`` in front of new lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.wording import diagnose

_MARKER = re.compile(r"(?:<{7}|\|{7}|>{7})(?: .*)?\Z|={7}\Z")
_FIRST, _LAST = "<<<<<<<", ">>>>>>>"
_MERGED = (
    "belongs to a merge conflict; keep one of the two sides, and delete the lines that begin with "
    "'<<<<<<<', '=======' and '>>>>>>>'"
)
_COMPARED = (
    "belongs to a diff of two versions; keep the lines that begin with '+', without the sign, and "
    "delete the lines that begin with '-', or vice versa"
)
# A line of the newer version has a plus sign in front of a key or an item.
_NEWER = re.compile(r"\+\s*(?:- \s*\S|[\w*'\"-]+\s*:(?:\s|$))")


def conflicts(lines: list[str], file: str) -> Iterator[Diagnostic]:
    """Yield one diagnostic for each conflict or diff, and for each stray marker."""
    is_inside = False
    for number, line in enumerate(lines, 1):
        if not _is_marker(line):
            continue
        mark = line[:7]
        # The first marker of a conflict represents it. A marker outside of a conflict is reported
        # by itself.
        if mark == _FIRST or not is_inside:
            yield diagnose("CB122", Place(file, number, 1, 8), problem=f"'{mark}' {_MERGED}")
        is_inside = mark == _FIRST or (is_inside and mark != _LAST)
    for number, *_ in _comparisons(lines):
        mark = lines[number - 1][0]
        yield diagnose("CB122", Place(file, number, 1, 2), problem=f"'{mark}' {_COMPARED}")


def one_side(lines: list[str]) -> list[str]:
    """Return the first side of each conflict and the newer version of each diff.

    Every line keeps its number.
    """
    kept, is_inside, is_other = [], False, False
    for line in lines:
        is_mark = _is_marker(line)
        if is_mark:
            is_inside = line[:7] == _FIRST or (is_inside and line[:7] != _LAST)
            is_other = is_inside and line[:7] != _FIRST
        kept.append("" if is_mark or is_other else line)
    for number in (number for run in _comparisons(kept) for number in run):
        line = kept[number - 1]
        kept[number - 1] = line[1:] if line[0] == "+" else ""
    return kept


def _is_marker(line: str) -> bool:
    return line[:1] in ("<", "|", "=", ">") and _MARKER.match(line) is not None


def _comparisons(lines: list[str]) -> Iterator[list[int]]:
    """Yield the line numbers of each run of lines that begin with the signs of a diff."""
    for is_signed, run in groupby(enumerate(lines, 1), lambda row: row[1][:1] in ("+", "-")):
        numbered = list(run) if is_signed else []
        # Lines that begin with "-" alone are usually the items of a list.
        if any(_NEWER.match(line) for _, line in numbered):
            yield [number for number, _ in numbered]
