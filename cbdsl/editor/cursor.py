"""Cursor in a document: the keys that enclose it, and the word around it.

The code reads the text alone, because a document is seldom valid while it is edited.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

_KEY = re.compile(
    r"""^(?P<indent>\s*)(?:-\s+)?["']?(?P<key>[^\s"'#{}\[\],][^"'#{}\[\],:(]*(?:\([^()]*\))?[^"'#{}\[\],:]*)["']?:(?=\s|$)"""
)
# In brackets: a key with its colon, a bracket or a comma; quoted text contains none.
_TOKEN = re.compile(
    r"""(?P<quoted>"[^"]*"|'[^']*')|(?P<key>[^\s{}\[\],:"'][^{}\[\],:"']*):(?=\s|$)|[{}\[\],]"""
)
# Words are names with dots, such as right_arm.position, and parameters, such as $arm.
_BEFORE, _AFTER = re.compile(r"\$?[\w.]*$"), re.compile(r"^[\w.]*")


class Cursor(NamedTuple):
    """Place in a document.

    Attributes:
        steps: Enclosing keys from the outside; the last one may be the key of the current value.
        word: Name around the cursor; empty between words.
        start, end: Columns of the word, from 0, ``end`` exclusive.
        on_key: True if the cursor is on a key instead of a value.
    """

    steps: tuple[str, ...]
    word: str
    start: int
    end: int
    on_key: bool

    @property
    def key(self) -> str:
        """Innermost key; empty at the top level."""
        return self.steps[-1] if self.steps else ""


class EnclosingKeys:
    """Keys that enclose each line of a text, found once for all places in it.

    Args:
        lines: Lines of the text.
    """

    def __init__(self, lines: Sequence[str]) -> None:
        self._lines, self._above = lines, list(_keys_above(lines))

    def cursor(self, line: int, column: int) -> Cursor:
        """Return the cursor at a line and column; see ``cursor``."""
        above = self._above[min(line, len(self._lines))]
        return _cursor(self._lines, line, column, above)


def cursor(lines: Sequence[str], line: int, column: int) -> Cursor:
    """Return the cursor at a line and column.

    Args:
        lines: Lines of the text.
        line: Line, from 0; a line after the last is empty.
        column: Number of characters before the cursor.
    """
    return EnclosingKeys(lines).cursor(line, column)


def _cursor(
    lines: Sequence[str], line: int, column: int, above: tuple[tuple[int, str], ...]
) -> Cursor:
    text = lines[line] if 0 <= line < len(lines) else ""
    before, after = text[:column], text[column:]
    head, tail = _BEFORE.search(before), _AFTER.search(after)
    assert head is not None, "the pattern matches the empty text"
    assert tail is not None, "the pattern matches the empty text"
    word, start = head[0] + tail[0], len(before) - len(head[0])
    opened, own = _in_line(before)
    # On an empty line, the column of the cursor is the indentation of the key that may follow.
    indent = len(text) - len(text.lstrip()) if text.strip() else column
    outer = [key for its_indent, key in above if its_indent < indent]
    written = re.match(r"\s*:(\s|$)", after[len(tail[0]) :]) is not None
    on_key = written or (own is None)
    steps = (*outer, *opened) if own is None else (*outer, *opened, own)
    return Cursor(steps, word, start, column + len(tail[0]), on_key)


def _in_line(before: str) -> tuple[list[str], str | None]:
    """Return the keys whose braces are open on the line, and the key of the current value."""
    match = _KEY.match(before)
    own = match["key"].strip() if match else None
    # Each open bracket is kept with the key of its value. Braces begin a new key, also after each
    # comma; in square brackets, all items belong to the same key.
    frames: list[tuple[str, str | None]] = []
    for token in _TOKEN.finditer(before, match.end() if match else 0):
        mark = token[0]
        if token["key"] is not None:
            own = token["key"].strip()
        elif mark in ("{", "["):
            frames.append((mark, own))
            own = None if mark == "{" else own
        elif mark in ("}", "]") and frames:
            _, own = frames.pop()
        elif mark == "," and frames and frames[-1][0] == "{":
            own = None
    return [key for bracket, key in frames if bracket == "{" and key is not None], own


def _keys_above(lines: Sequence[str]) -> Iterator[tuple[tuple[int, str], ...]]:
    """Yield the keys above each line, and after the last, that may enclose it, with their indents.

    Indents grow from key to key: a key that is not indented more than an earlier one ends it.
    """
    open_keys: tuple[tuple[int, str], ...] = ()
    yield open_keys
    for text in lines:
        match = _KEY.match(text)
        if match:
            indent = len(match["indent"])
            outer = tuple(each for each in open_keys if each[0] < indent)
            open_keys = (*outer, (indent, match["key"].strip()))
        yield open_keys
