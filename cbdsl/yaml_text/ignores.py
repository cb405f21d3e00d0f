"""Comments that suppress a diagnostic: ``# cb: ignore CB701 kept for the demonstration``."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from typing import Any, NamedTuple

import yaml

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.lines import lines_of
from cbdsl.yaml_text.composer import LOADER, MOST_CHARACTERS

_IGNORE = re.compile(r"(?:^|(?<=\s))#\s*cb: ignore\b[ \t]*(?P<code>\w*)(?P<reason>.*)")
_COMMENT = re.compile(r"\s*(?:#|$)")


class Ignore(NamedTuple):
    """Comment that suppresses a diagnostic.

    Attributes:
        code: Code of the suppressed diagnostic, as written.
        reason: Reason given, or an empty text.
        place: Place of the comment.
        line: Line of the suppressed diagnostic, from 1.
    """

    code: str
    reason: str
    place: Place
    line: int


def read_ignores(text: str, file: str) -> list[Ignore]:
    """Return the comments of a text that suppress diagnostics.

    A trailing comment suppresses diagnostics on its line; a full-line comment, those on the next
    non-blank, non-comment line.
    """
    if len(text) > MOST_CHARACTERS:
        return []
    lines, quoted = lines_of(text), _Scalars(text)
    below = _lines_below(lines)
    ignores = []
    for number, line in enumerate(lines, 1):
        match = _IGNORE.search(line)
        if match and not quoted.hold(number, match.start()):
            place = Place(file, number, match.start() + 1, len(line.rstrip()) + 1)
            target = number if line[: match.start()].strip() else below[number - 1]
            ignores.append(Ignore(match["code"], match["reason"].strip(), place, target))
    return ignores


def _lines_below(lines: list[str]) -> list[int]:
    """Return for each line the number of the next non-blank, non-comment line, or its own."""
    below, following = [], 0
    for number in range(len(lines), 0, -1):
        below.append(following or number)
        if not _COMMENT.match(lines[number - 1]):
            following = number
    return below[::-1]


class _Scalars:
    """Spans of the scalars of a document, in which a ``#`` does not begin a comment."""

    def __init__(self, text: str) -> None:
        spans = [(_position(e.start_mark), _position(e.end_mark)) for e in _scalars(text)]
        self._starts = [start for start, _ in spans]
        self._ends = [end for _, end in spans]

    def hold(self, line: int, column: int) -> bool:
        """Return whether a character is part of a scalar; lines from 1, columns from 0."""
        # Scalars do not overlap and are sorted by their starts. Only the last one that begins at or
        # before a position can hold it.
        position = (line - 1, column)
        i = bisect_right(self._starts, position) - 1
        return i >= 0 and position < self._ends[i]


def _position(mark: Any) -> tuple[int, int]:
    return mark.line, mark.column


def _scalars(text: str) -> Iterator[Any]:
    """Yield the scalar events of a YAML text, up to its first syntax error."""
    loader = LOADER(text)
    try:
        while loader.check_event():
            event = loader.get_event()
            if isinstance(event, yaml.ScalarEvent):
                yield event
    except yaml.YAMLError:
        return
