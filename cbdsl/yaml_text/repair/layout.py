"""Indentation of the lines of a document, and search for the misaligned line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, takewhile
from typing import NamedTuple

_ROW = re.compile(
    r"(?P<indent> *)(?P<dash>- +|-$)?"
    r"(?:(?P<key>[^\s#&*!|>'\"%@`{\[-][^:#]*|(?:[^\s:#]+|'[^']*'|\"[^\"]*\") *):(?= |$))?"
    r"(?P<rest>.*)"
)
_TEXT_BELOW = re.compile(r"\s*[|>][-+0-9]*\s*(?:#.*)?\Z")
_NOT_A_BRACKET = re.compile(r"'[^']*'|\"[^\"]*\"|(?:^|\s)#.*")
_ANCHOR_ALONE = re.compile(r"\s*(?:&\w+\s*)?(?:#.*)?\Z")


class Row(NamedTuple):
    """Line that begins a key or an item.

    Attributes:
        line: Line number, from 1.
        indent: Number of leading spaces.
        is_item: True if the line begins with ``-``.
        name: Key, or the content of the item.
        opens: True if the value of its key is on the lines below.
    """

    line: int
    indent: int
    is_item: bool
    name: str
    opens: bool

    def __str__(self) -> str:
        return f"'{self.name}' in line {self.line}"


class Realignment(NamedTuple):
    """Remedy for a misaligned line.

    Attributes:
        problem: Message, as a sentence without a full stop.
        line: Line number, from 1.
        column: Column of the line's first character, from 1.
        lines: Corrected lines by number, if the correction is certain.
    """

    problem: str
    line: int
    column: int
    lines: Mapping[int, str] = {}


# A misaligned line is often valid where it stands, and only a line below it is a syntax error. The
# text is therefore reduced to rows: lines that begin a key or an item, with their indentations.
# Three hypotheses are tested, the most specific one first. Rows may stand on the level of the key
# that opens their section. A row may have a dash among rows without one, or vice versa. Otherwise a
# row is indented unlike its neighbours. A correction is applied only if a single level is possible,
# since a wrong one would change the meaning of the document.
def find_shift(lines: Sequence[str], line: int) -> Realignment | None:
    """Return the remedy for the misaligned line that causes a syntax error at a line."""
    rows = list(_rows(lines))
    index = next((i for i, row in enumerate(rows) if row.line == line), 0)
    if index == 0:
        return None
    outline = _Outline(lines, rows, index)
    return outline.children() or outline.dash() or outline.odd_one()


def _rows(lines: Sequence[str]) -> Iterator[Row]:
    """Yield the lines that begin a key or an item, except within texts and brackets."""
    # The state is the indentation of a key whose block text follows, or -1, and that of the text's
    # first line. It includes the number of open brackets and the indentation of the last row, too.
    below, text_indent, depth, last = -1, None, 0, 0
    for number, line in enumerate(lines, 1):
        stripped = line.strip()
        if not stripped or stripped[0] == "#":
            continue
        indent = len(line) - len(line.lstrip(" "))
        if below >= 0:
            text_indent = indent if text_indent is None else text_indent
            if indent >= text_indent > below:
                continue
            below, text_indent = -1, None
        row = _ROW.match(line)
        assert row is not None, "every part of it may be empty"
        rest = row["rest"]
        is_row = row["dash"] is not None or row["key"] is not None
        # A line that is not indented more than its row cannot continue the row's brackets. They are
        # probably never closed, and counting starts from scratch.
        if is_row and not (depth > 0 and indent > last):
            name = (row["key"] or rest).strip()
            opens = row["key"] is not None and _ANCHOR_ALONE.match(rest) is not None
            yield Row(number, indent, row["dash"] is not None, name, opens)
            depth, last = 0, indent
            below = indent if _TEXT_BELOW.match(rest) else -1
        bare = _NOT_A_BRACKET.sub("", rest)
        depth += sum(map(bare.count, "[{")) - sum(map(bare.count, "]}"))


class _Outline:
    """Rows around the row of a syntax error."""

    def __init__(self, lines: Sequence[str], rows: list[Row], index: int) -> None:
        self._lines = lines
        self._rows = rows
        self._index = index
        self._row = rows[index]
        self._before = rows[index - 1]

    def children(self) -> Realignment | None:
        """Return the remedy for rows that are indented like their own parent key."""
        row = self._row
        for parent, child in list(pairwise(self._rows[: self._index]))[::-1]:
            is_level = not child.is_item and child.indent == parent.indent < row.indent
            if parent.opens and is_level:
                by = row.indent - parent.indent
                numbers = range(child.line, row.line)
                moved = {number: " " * by + self._lines[number - 1] for number in numbers}
                what = f"it belongs to {parent}, as the lines below do"
                problem = f"{what}; indent them by {_spaces(by)} more"
                return Realignment(problem, child.line, child.indent + 1, moved)
        return None

    def dash(self) -> Realignment | None:
        """Return the remedy for a row with ``-`` among rows without it, or vice versa."""
        row, level = self._row, self._level()
        sibling = next((other for other in level if other.is_item != row.is_item), None)
        if sibling is None or (row.is_item and self._before.is_item):
            return None
        if len(level) == 1 and sibling.is_item and len(self._run()) > 1:
            row, sibling = sibling, row
        begin = row.indent + 1
        if row.is_item:
            problem = f"it begins with '-', and {sibling} does not; leave the '-' out"
            return Realignment(problem, row.line, begin)
        section = self._opening(row.indent)
        other = f", or indent it by {_spaces(section.indent)}, like {section}" if section else ""
        problem = f"items of a list begin with '- ', like {sibling}; begin it with '- '{other}"
        return Realignment(problem, row.line, begin)

    def odd_one(self) -> Realignment | None:
        """Return the remedy for a row that is indented differently from the rows around it."""
        row, before = self._row, self._before
        earlier = self._rows[self._index - 2] if self._index > 1 else None
        level, run = self._level_of(before), self._run()
        if row.indent > before.indent and earlier is not None and earlier.indent > before.indent:
            return self._shift(before, [*dict.fromkeys((row, earlier))])
        if len(level) < len(run) and not before.opens:
            return self._shift(level[-1], [row]) if len(level) == 1 else None
        if row.indent > before.indent:
            return None if before.opens else self._shift(row, [before])
        return self._shift(row, self._neighbours())

    def _neighbours(self) -> list[Row]:
        """Return the rows above on the adjacent levels, preferring the level of the row below."""
        above, indent = self._rows[: self._index][::-1], self._row.indent
        inner = list(takewhile(lambda other: other.indent > indent, above))
        levels = [min(inner, key=lambda other: other.indent)] if inner else []
        levels += [other for other in above if other.indent < indent][:1]
        following = self._rows[self._index + 1 : self._index + 2]
        agreed = [other for other in levels if following and other.indent == following[0].indent]
        return agreed or levels

    def _shift(self, row: Row, neighbours: list[Row]) -> Realignment:
        levels = {other.indent: other for other in neighbours}
        ways = [f"by {_spaces(indent)}, like {other}" for indent, other in levels.items()]
        problem = f"it is indented by {_spaces(row.indent)}; indent it {' or '.join(ways)}"
        line = self._lines[row.line - 1]
        is_certain = len(levels) == 1 and not row.opens
        moved = {row.line: " " * next(iter(levels)) + line.lstrip(" ")} if is_certain else {}
        return Realignment(problem, row.line, row.indent + 1, moved)

    def _level(self) -> list[Row]:
        """Return the rows above with the indentation of this row, in the same section."""
        rows = []
        for other in self._rows[: self._index][::-1]:
            if other.indent < self._row.indent:
                break
            if other.indent == self._row.indent:
                rows.append(other)
        return rows

    def _level_of(self, row: Row) -> list[Row]:
        """Return a row and the rows directly above it with the same indentation."""
        rows = []
        for other in self._rows[: self._index][::-1]:
            if other.indent != row.indent:
                break
            rows.append(other)
        return rows

    def _run(self) -> list[Row]:
        """Return this row and the rows below it with the same indentation, in the same section."""
        rows = []
        for other in self._rows[self._index :]:
            if other.indent < self._row.indent or other.is_item != self._row.is_item:
                break
            if other.indent == self._row.indent:
                rows.append(other)
        return rows

    def _opening(self, indent: int) -> Row | None:
        """Return the nearest key above that opens a section and is indented less."""
        above = self._rows[: self._index][::-1]
        return next((row for row in above if row.opens and row.indent < indent), None)


def _spaces(count: int) -> str:
    return f"{count} space{'' if count == 1 else 's'}"
