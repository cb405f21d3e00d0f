"""Positions of an editor: lines and columns in the negotiated units."""

from __future__ import annotations

import re
from bisect import bisect_right
from itertools import accumulate
from typing import Protocol

from lsprotocol import types as lsp

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.lines import line_ends, lines_of

# The protocol has fewer line ends than YAML, by which diagnostics count lines.
_BREAK = re.compile("\r\n|[\n\r]")


class Codec(Protocol):
    """Encoding of positions that server and editor agreed on."""

    def client_num_units(self, string: str) -> int:
        """Return the number of code units of a text."""


# Places and positions differ in two ways. Places count lines by the line ends of YAML 1.1, which
# include U+0085, U+2028 and U+2029, and columns by characters. The protocol has fewer line ends,
# and columns by code units, of which an emoji has two in UTF-16. Both are converted through the
# offset in the text.
class Positions:
    """Conversion between places in a text and positions of an editor.

    Lines and columns of a text count characters, from 0, in lines as ``lines_of`` ends them.

    Args:
        text: Text of the document.
        codec: Encoding of the positions.
    """

    def __init__(self, text: str, codec: Codec) -> None:
        self._text, self._units = text, codec.client_num_units
        ended = zip(lines_of(text), line_ends(text), strict=False)
        self._lines = [0, *accumulate(len(line) + len(end) for line, end in ended)]
        self._shown = [0, *(match.end() for match in _BREAK.finditer(text))]

    def range(self, line: int, start: int, end: int) -> lsp.Range:
        """Convert a span of a line.

        Args:
            line: Line of the span, from 0.
            start: Column of its first character; columns beyond the line count one unit each.
            end: Column after its last character.
        """
        return lsp.Range(self._position(line, start), self._position(line, end))

    def of_place(self, place: Place) -> lsp.Range:
        """Convert the place of a diagnostic."""
        return self.range(place.line - 1, place.column - 1, place.end_column - 1)

    def whole(self) -> lsp.Range:
        """Return the range of the whole text."""
        start = self._shown[-1]
        end = lsp.Position(len(self._shown) - 1, self._units(self._text[start:]))
        return lsp.Range(lsp.Position(0, 0), end)

    def spot(self, position: lsp.Position) -> tuple[int, int]:
        """Convert a position into a line and a column; limit the column to the line's end."""
        if position.line >= len(self._shown):
            return len(self._lines) + position.line - len(self._shown), 0
        line = position.line
        offset = self._shown[line]
        ends = self._shown[line + 1] if line + 1 < len(self._shown) else len(self._text)
        stretch = self._text[offset:ends].rstrip("\r\n")
        widths = accumulate(self._units(character) for character in stretch)
        # A position between two units of one character precedes the character.
        offset += bisect_right(list(widths), position.character)
        line = bisect_right(self._lines, offset) - 1
        return line, offset - self._lines[line]

    def _position(self, line: int, column: int) -> lsp.Position:
        if not 0 <= line < len(self._lines):
            return lsp.Position(max(line, 0), max(column, 0))
        ends = self._lines[line + 1] if line + 1 < len(self._lines) else len(self._text)
        stretch = self._text[self._lines[line] : ends].rstrip("\r\n\x85\u2028\u2029")
        inside = min(max(column, 0), len(stretch))
        offset = self._lines[line] + inside
        shown = bisect_right(self._shown, offset) - 1
        units = self._units(self._text[self._shown[shown] : offset])
        return lsp.Position(shown, units + max(column - inside, 0))
