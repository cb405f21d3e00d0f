"""Formatter of YAML text: the same values and comments, evenly indented and spaced."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import yaml

from cbdsl.diagnostics.lines import lines_of
from cbdsl.yaml_text.composer import LOADER, YamlSyntaxError

#: Columns by which a block is indented relative to its parent.
INDENT = 2

# A block text with an explicit indentation indicator: its columns cannot be changed.
_COUNTED = re.compile(r"[|>][+-]?[1-9]")
_OPENING = (yaml.FlowMappingStartToken, yaml.FlowSequenceStartToken)
_CLOSING = (yaml.FlowMappingEndToken, yaml.FlowSequenceEndToken)
_BLOCKS = (yaml.BlockMappingStartToken, yaml.BlockSequenceStartToken)
# Tokens that documents do not need and that would require rules of their own.
_LEFT_ALONE = (yaml.TagToken, yaml.DirectiveToken)
_UNSEEN = (yaml.StreamStartToken, yaml.StreamEndToken, yaml.BlockEndToken, *_BLOCKS)
_TIGHT_AFTER = ("[", "{")
_TIGHT_BEFORE = ("]", "}", ",", ":")

#: Line and column of a first character, from 0.
_Start = tuple[int, int]


# The formatter works on tokens, because comments are not parts of nodes. Each visible token becomes
# one piece for each of its lines. A line that begins a key or an item is indented by the depth of
# its block. A line within brackets moves by as much as the begin of the outermost bracket. The
# lines of a block text move together. Line breaks are neither added nor removed, except that
# several empty lines become one. A full-line comment follows the line below that had the same
# indentation, or else the nearest such line above. The result is used only if its events and
# comments are those of the given text.
class UnknownLayoutError(Exception):
    """Text whose layout has a meaning that the formatter does not support."""


class _Block(NamedTuple):
    """Block collection in the formatted text.

    Attributes:
        column: Column of its keys or dashes, from 0.
        is_list: True if entries begin with a dash.
        has_start: True if the scanner emits start and end tokens; false for lists at the
            indentation of their key.
    """

    column: int
    is_list: bool
    has_start: bool = True


class _Piece(NamedTuple):
    """Part of a line that belongs to one token.

    Attributes:
        text: Text as written in the line.
        column: First column, from 0.
        end: Column after the last character.
        indent: New column if the piece begins a line; ``None`` keeps its distance from the start
            of its brackets.
        opened: Start of its outermost brackets, or of its text.
        least: Minimum new column.
        is_sign: True if it is punctuation instead of text.
    """

    text: str
    column: int
    end: int
    indent: int | None
    opened: _Start
    least: int
    is_sign: bool


def formatted(text: str) -> str:
    """Return the formatted text, or the text unchanged if formatting would alter its meaning.

    Raises:
        YamlSyntaxError: The text is not valid YAML.
    """
    given = text.removeprefix("\ufeff")
    try:
        events = _events(given)
    except yaml.MarkedYAMLError as error:
        raise YamlSyntaxError(error, ()) from None
    try:
        result = _laid_out(given)
        # Some line breaks of the given text may be parts of values.
        is_same = _events(result) == events and comments(result) == comments(given)
    except (UnknownLayoutError, yaml.MarkedYAMLError):
        return text
    return result if is_same else text


def _laid_out(text: str) -> str:
    lines = [line.rstrip("\r\n") for line in lines_of(text)]
    return _Layout("\n".join(lines) + "\n", lines).text()


def comments(text: str) -> list[str]:
    """Return all comments of a text, from top to bottom.

    Raises:
        yaml.YAMLError: The text is not valid YAML.
    """
    lines = lines_of(text)
    ends: dict[int, int] = {}
    within: set[int] = set()
    for token in _tokens(text):
        start, end = _position(token.start_mark), _position(token.end_mark)
        within.update(_inner_lines(token))
        if end != start:
            ends[end[0]] = max(ends.get(end[0], 0), end[1])
    # A comment can begin only behind the last token of a line, and not within a text of several
    # lines.
    rests = (
        line[ends.get(number, 0) :].strip()
        for number, line in enumerate(lines)
        if number not in within or number in ends
    )
    return [rest for rest in rests if rest.startswith("#")]


def _tokens(text: str) -> Iterator[Any]:
    return iter(yaml.scan(text, Loader=LOADER))


def _events(text: str) -> list[tuple[Any, ...]]:
    """Return the values and structure of a text, without positions and bracket styles."""
    return [
        (type(event), *(getattr(event, name, None) for name in ("value", "style", "anchor")))
        for event in yaml.parse(text, Loader=LOADER)
    ]


def _position(mark: Any) -> tuple[int, int]:
    return mark.line, mark.column


def _inner_lines(token: Any) -> range:
    """Return the numbers of the lines that continue a scalar after its first line."""
    if not isinstance(token, yaml.ScalarToken):
        return range(0)
    end = token.end_mark
    return range(token.start_mark.line + 1, end.line + (1 if end.column else 0))


class _Layout:
    """Lines of a text, split into pieces and joined in the new layout.

    Args:
        source: Text with a line feed at the end of each line.
        lines: Lines of the text without line ends.
    """

    def __init__(self, source: str, lines: Sequence[str]) -> None:
        self._lines = lines
        self._pieces: list[list[_Piece]] = [[] for _ in lines]
        # Shifts of the lines of block texts, which change only in their indentation.
        self._shifts: dict[int, int] = {}
        # Lines that continue a text, including empty ones.
        self._continued: set[int] = set()
        self._blocks: list[_Block] = []
        self._opened: list[_Start] = []
        # New columns of pieces by their old positions.
        self._columns: dict[_Start, int] = {}
        self._key_begins = False
        for token in _tokens(source):
            self._take(token)

    def text(self) -> str:
        """Return the formatted text."""
        indents: list[int | None] = []
        made: list[str] = []
        for number in range(len(self._lines)):
            indent, line = self._line(number)
            indents.append(indent)
            made.append(line)
        kept = self._with_comments(made, indents)
        return "\n".join(self._without_gaps(kept)).strip("\n") + "\n"

    def _take(self, token: Any) -> None:
        """Place the next token."""
        if isinstance(token, _LEFT_ALONE):
            raise UnknownLayoutError
        if isinstance(token, _BLOCKS):
            is_list = isinstance(token, yaml.BlockSequenceStartToken)
            self._blocks.append(_Block(self._below(), is_list))
        elif isinstance(token, yaml.BlockEndToken):
            self._leave_bare_list()
            self._blocks.pop()
        elif isinstance(token, yaml.KeyToken):
            self._begin_key(token)
            return
        elif isinstance(token, yaml.BlockEntryToken):
            self._enter_bare_list()
        if not isinstance(token, _UNSEEN):
            self._place(token)
        if isinstance(token, _OPENING):
            self._opened.append(_position(token.start_mark))
        elif isinstance(token, _CLOSING):
            if not self._opened:
                raise UnknownLayoutError
            self._opened.pop()

    def _enter_bare_list(self) -> None:
        """Enter a list at the indentation of its key; the formatter preserves this indentation."""
        if self._opened:
            raise UnknownLayoutError  # between brackets, where a parser refuses it
        if not self._blocks[-1].is_list:
            self._blocks.append(_Block(self._blocks[-1].column, True, has_start=False))

    def _begin_key(self, token: Any) -> None:
        if _position(token.start_mark) != _position(token.end_mark):
            raise UnknownLayoutError  # written as "? key"
        if not self._opened:
            self._leave_bare_list()
            self._key_begins = True

    def _below(self) -> int:
        """Return the column of a block that begins here."""
        return self._blocks[-1].column + INDENT if self._blocks else 0

    def _leave_bare_list(self) -> None:
        if self._blocks and not self._blocks[-1].has_start:
            self._blocks.pop()

    def _place(self, token: Any) -> None:
        """Record the pieces of a visible token."""
        start, end = token.start_mark, token.end_mark
        line = self._lines[start.line] if start.line < len(self._lines) else ""
        is_text = isinstance(token, yaml.ScalarToken)
        if is_text and token.style in ("|", ">"):
            self._place_block_text(token, line)
            return
        inner = _inner_lines(token)
        stop = len(line.rstrip()) if inner else end.column
        opened = self._opened[0] if self._opened else _position(start)
        piece = _Piece(
            line[start.column : stop], start.column, stop, self._indent(token), opened,
            self._below(), not is_text,
        )  # fmt: skip
        self._pieces[start.line].append(piece)
        self._key_begins = False
        self._continued.update(inner)
        column_of_text = None if self._opened else self._below()
        for number in inner:
            rest = self._lines[number]
            column = len(rest) - len(rest.lstrip())
            stop = end.column if number == end.line else len(rest.rstrip())
            if stop > column:
                piece = _Piece(
                    rest[column:stop], column, stop, column_of_text, opened, self._below(), False
                )
                self._pieces[number].append(piece)

    def _place_block_text(self, token: Any, line: str) -> None:
        start = token.start_mark
        header = line[start.column :].rstrip()
        if _COUNTED.match(header):
            raise UnknownLayoutError
        indent = self._indent(token)
        self._pieces[start.line].append(
            _Piece(header, start.column, len(line), indent, _position(start), self._below(), False)
        )
        self._key_begins = False
        inner = [number for number in _inner_lines(token) if number < len(self._lines)]
        first = next((self._lines[n] for n in inner if self._lines[n].strip()), "")
        shift = self._below() - (len(first) - len(first.lstrip()))
        self._shifts.update(dict.fromkeys(inner, shift))

    def _indent(self, token: Any) -> int | None:
        """Return the column of a token that begins a line, or ``None`` within brackets."""
        if self._opened:
            return None
        if isinstance(token, yaml.BlockEntryToken):
            return self._blocks[-1].column
        if self._key_begins:
            return self._blocks[-1].column
        return self._below()

    def _line(self, number: int) -> tuple[int | None, str]:
        """Return a line's indentation and its formatted text; full-line comments get none yet."""
        line = self._lines[number]
        if number in self._shifts:
            content = line.lstrip(" ")
            column = max(len(line) - len(content) + self._shifts[number], 0)
            return None, " " * column + content if content.strip() else line.strip("\n")
        pieces = self._pieces[number]
        if not pieces:
            return None, line.strip()
        first = pieces[0]
        indent = first.indent
        if indent is None:
            moved = self._columns[first.opened] - first.opened[1]
            indent = max(first.column + moved, first.least)
        rest = line[pieces[-1].end :]
        made = " " * indent
        for before, piece in pairwise((None, *pieces)):
            assert piece is not None, "only the first has nothing before it"
            made += _gap(before, piece) if before else ""
            self._columns[number, piece.column] = len(made)
            made += piece.text
        return indent, (made + rest).rstrip()

    def _with_comments(self, made: Sequence[str], indents: Sequence[int | None]) -> list[str]:
        """Return the lines with full-line comments indented like the line that they describe."""
        result = list(made)
        below: tuple[int, int] | None = None
        # From the last line upwards, because a comment usually describes the line below it.
        for number in range(len(made) - 1, -1, -1):
            line = self._lines[number]
            old = len(line) - len(line.lstrip())
            indent = indents[number]
            if indent is not None:
                below = old, indent
            elif made[number].startswith("#") and number not in self._shifts:
                near = (
                    self._alike(number, old, indents) if below is None or below[0] != old else None
                )
                wanted = near if near is not None else below[1] if below is not None else 0
                result[number] = " " * wanted + made[number]
        return result

    def _alike(self, number: int, old: int, indents: Sequence[int | None]) -> int | None:
        """Return the new indentation of the nearest line above that was indented like a comment."""
        for above in range(number - 1, -1, -1):
            line = self._lines[above]
            if indents[above] is not None and len(line) - len(line.lstrip()) == old:
                return indents[above]
        return None

    def _without_gaps(self, lines: Sequence[str]) -> Iterator[str]:
        """Yield the lines with consecutive empty lines merged, except within texts."""
        for number, line in enumerate(lines):
            is_gap = not line and number not in self._shifts and number not in self._continued
            if not (is_gap and number and not lines[number - 1]):
                yield line


def _gap(one: _Piece, other: _Piece) -> str:
    """Return the space between two neighbouring pieces of a line."""
    if one.is_sign and one.text in _TIGHT_AFTER:
        return ""
    # A colon directly after an alias would be part of its name.
    is_alias = other.text == ":" and one.text.startswith("*")
    if other.is_sign and other.text in _TIGHT_BEFORE and not is_alias:
        return ""
    return " "
