"""What git leaves in a file whose two versions it could not merge."""

from __future__ import annotations

import re
from collections.abc import Iterator

from cbdsl.errors.diagnostic import Diagnostic, Place
from cbdsl.errors.wording import diagnostic

_MARKER = re.compile(r"(?:<{7}|\|{7}|>{7})(?: .*)?\Z|={7}\Z")
_FIRST, _LAST = "<<<<<<<", ">>>>>>>"


def is_marker(line: str) -> bool:
    """Whether git wrote a line."""
    return line[:1] in ("<", "|", "=", ">") and _MARKER.match(line) is not None


def conflicts(lines: list[str], file: str) -> Iterator[Diagnostic]:
    """One finding for each conflict, and for each line that is left of one."""
    is_inside = False
    for number, line in enumerate(lines, 1):
        if not is_marker(line):
            continue
        mark = line[:7]
        if mark == _FIRST or not is_inside:
            yield diagnostic("CB122", Place(file, number, 1, 8), marker=mark)
        is_inside = mark == _FIRST or (is_inside and mark != _LAST)


def first_sides(lines: list[str]) -> list[str]:
    """The first side of each conflict; every line keeps its number."""
    kept, is_inside, is_other = [], False, False
    for line in lines:
        is_mark = is_marker(line)
        if is_mark:
            is_inside = line[:7] == _FIRST or (is_inside and line[:7] != _LAST)
            is_other = is_inside and line[:7] != _FIRST
        kept.append("" if is_mark or is_other else line)
    return kept
