"""What YAML's syntax errors mean: libyaml says where it gave up, and people slipped before."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

_NO_COLON = "could not find expected ':'"
_NO_MAPPING = "mapping values are not allowed in this context"
_NO_COMMA = "did not find expected ',' or "
_NO_KEY = "did not find expected key"

_KEY = re.compile(r"\s*(?:- +)*(?P<key>[^\s:#][^:#]*):\s")
_TIGHT = re.compile(r"\s*(?:- +)*(?P<key>\w+):(?P<value>[^\s:/].*)")
_FIRST = re.compile(r"\s*(?:- +)*(?P<key>\S+)")
_OPENED = re.compile(r"\s*(?:- +)*\w+:? *(?:&\w+ +)?[{\[]")


class Slip(NamedTuple):
    """What somebody probably did.

    Attributes:
        problem: as a clause.
        line: where it is, from 1.
        column: of its first character, from 1.
    """

    problem: str
    line: int
    column: int


def find_slip(problem: str, lines: Sequence[str], line: int, column: int) -> Slip | None:
    """The slip behind a syntax error, or ``None`` where nobody can tell.

    Args:
        problem: what libyaml says.
        lines: of the text.
        line: where libyaml noticed it, from 1.
        column: where in the line, from 1.
    """
    if not 0 < line <= len(lines):
        return None
    if problem == _NO_COLON:
        return _no_colon(lines, line)
    if problem == _NO_KEY:
        rows = (row for row in (line, line - 1) if row and _OPENED.match(lines[row - 1]))
        return next((slip for row in rows if (slip := _no_colon(lines, row))), None)
    if problem == _NO_MAPPING:
        return _second_colon(lines, line, column) or _above(lines, line)
    before, at = lines[line - 1][: column - 1], lines[line - 1][column - 1 : column]
    # The first key of a line tells more of a bracket above that is not closed.
    if problem.startswith(_NO_COMMA) and at == ":" and not re.fullmatch(r"\s*\w+", before):
        meant = (
            "a ',' is missing before this key, or the text before it holds ': ' and needs quotes"
        )
        return Slip(meant, line, column)
    return None


def _no_colon(lines: Sequence[str], line: int) -> Slip | None:
    """A line that should have a key, and has no colon after it, or no space after that."""
    text = lines[line - 1]
    if tight := _TIGHT.match(text):
        key, value = tight["key"], tight["value"].strip()
        problem = f"a space is missing after the ':' of '{key}'; write '{key}: {value}'"
        return Slip(problem, line, tight.end("key") + 1)
    first = _FIRST.match(text)
    if first is None or first["key"].endswith(":"):
        return None
    return Slip(f"a ':' is missing after '{first['key']}'", line, first.end("key") + 1)


def _second_colon(lines: Sequence[str], line: int, column: int) -> Slip | None:
    """A text on the line of its key that holds a colon and a space."""
    key = _KEY.match(lines[line - 1][: column - 1])
    if key is None:
        return _no_colon(lines, line) if _TIGHT.match(lines[line - 1]) else None
    first, _, rest = key["key"].partition(" ")
    if re.match(r"(&\w+ +)?[{\[]", rest):
        return Slip(f"a ':' is missing after '{first}'", line, key.start("key") + len(first) + 1)
    value = lines[line - 1][key.end() :].strip()
    problem = f"a text that holds ': ' needs quotes; write '{key['key']}: \"{value}\"'"
    return Slip(problem, line, column)


def _above(lines: Sequence[str], line: int) -> Slip | None:
    """A line that is taken for more of the text above it."""
    before = (n for n in range(line - 1, 0, -1) if not re.match(r"\s*(#|$)", lines[n - 1]))
    number = next(before, None)
    if number is None:
        return None
    key = _KEY.match(lines[number - 1])
    if key is None:
        return _no_colon(lines, number)
    has = f"the key '{key['key']}' above has a value already, so nothing can be indented below it"
    return Slip(has, line, len(lines[line - 1]) - len(lines[line - 1].lstrip()) + 1)
