"""Places of the values of a document in its text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome
from cbdsl.yaml_text.broken import Broken
from cbdsl.yaml_text.declared import Declared
from cbdsl.yaml_text.node import Node

Step = str | int
T = TypeVar("T")

_NOTHING = Broken()


class SourceMap(NamedTuple):
    """File, lines and places of a document.

    Paths into the document are sequences of keys and indices. Steps that are absent from the
    text, such as the tags of unions, are skipped.

    Attributes:
        path: File of the document.
        lines: Lines of its text.
        root: Root of its values.
        broken: Faulty parts that were left out of ``root``.
    """

    path: Path
    lines: Sequence[str]
    root: Node
    broken: Broken = _NOTHING

    def known(self, value: T, *steps: Step) -> Outcome[T]:
        """Return the value of a path; unknown if a part at, above or below it was left out."""
        return UNKNOWN if self.broken.touches(steps) else value

    def declared(self, entries: Mapping[str, T], *section: Step) -> Declared[T]:
        """Return the entries of a section, including the omitted ones as unknown."""
        return Declared(entries, self.broken, section)

    def place(self, *steps: Step) -> Place:
        """Return the place of the value at a path, or of its enclosing value if it is absent."""
        return self.node(steps).place

    def key(self, *steps: Step) -> Place:
        """Return the place of the key at a path, or of its enclosing value if it is absent."""
        parent = self.node(steps[:-1])
        return parent.keys.get(str(steps[-1]), parent.place) if steps else parent.place

    def inside(self, steps: Sequence[Step], start: int, end: int) -> Place:
        """Return the place of a substring of a text value; columns from 1, ``end`` exclusive."""
        node = self.node(steps)
        return self._part(node.place, node.value, start, end)

    def inside_key(self, steps: Sequence[Step], start: int, end: int) -> Place:
        """Return the place of a substring of a key; columns from 1, ``end`` exclusive."""
        return self._part(self.key(*steps), steps[-1], start, end)

    def _part(self, place: Place, value: object, start: int, end: int) -> Place:
        if not isinstance(value, str):
            return place
        line = self.lines[place.line - 1]
        # A text without escapes stands in its line as it is, possibly within quotes.
        offset = line[place.column - 1 : place.end_column - 1].find(value)
        if offset >= 0:
            column = place.column + offset - 1
            return Place(place.file, place.line, column + start, column + end)
        return self._in_lines(place, value, start, end) or place

    def _in_lines(self, place: Place, value: str, start: int, end: int) -> Place | None:
        """Return the place of a substring of a multi-line text; YAML joins lines by spaces."""
        # Folding of lines changes spaces and breaks only. The other characters of value and text
        # thus correspond one by one.
        written = self._written(place)
        row, column, stretch = 0, 0, []
        for number, character in enumerate(value[: end - 1], 1):
            if character.isspace():
                continue
            row, column, written_as = next(written, (0, 0, ""))
            if written_as != character:  # it is written with escapes
                return None
            if number >= start:
                stretch.append((row, column))
        row, first = stretch[0] if stretch else (row, column + 1)
        last = max((c for r, c in stretch if r == row), default=first)
        return Place(place.file, row, first, last + 1)

    def _written(self, place: Place) -> Iterator[tuple[int, int, str]]:
        """Yield line, column and character of the text from a place on, without spaces."""
        opening = self.lines[place.line - 1][place.column - 1 : place.column]
        # A block text, as after `>-`, begins on the next line; a quoted text, after its quote.
        below = opening in (">", "|")
        skipped = 0 if below else place.column - 1 + (opening in ("'", '"'))
        for row in range(place.line + below, len(self.lines) + 1):
            for column, character in enumerate(self.lines[row - 1][skipped:], skipped + 1):
                if not character.isspace():
                    yield row, column, character
            skipped = 0

    def node(self, steps: Sequence[Step]) -> Node:
        """Return the deepest existing node along a path."""
        node = self.root
        for step in steps:
            node = child_of(node, step) or node
        return node

    def written(self, node: Node) -> str:
        """Return a value in flow style, with its texts and numbers as written."""
        if isinstance(node.value, dict):
            return f"{{{', '.join(f'{k}: {self.written(v)}' for k, v in node.value.items())}}}"
        if isinstance(node.value, list):
            return f"[{', '.join(map(self.written, node.value))}]"
        place = node.place
        return self.lines[place.line - 1][place.column - 1 : place.end_column - 1].strip()

    def holds(self, *steps: Step) -> bool:
        """Return whether the text itself holds a value at a path, instead of a default."""
        node: Node | None = self.root
        for step in steps:
            node = child_of(node, step) if node else None
        return node is not None


def child_of(node: Node, step: Step) -> Node | None:
    """Return the value of a mapping's key or the item of a sequence, or ``None``."""
    if isinstance(node.value, dict):
        return node.value.get(str(step))
    if isinstance(node.value, list) and isinstance(step, int) and step < len(node.value):
        return node.value[step]
    return None
