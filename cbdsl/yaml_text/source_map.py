"""Where every value of a document stands in its text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

from cbdsl.errors.diagnostic import Place
from cbdsl.yaml_text.broken import Broken
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.unknown import Declared

Step = str | int
T = TypeVar("T")

_NOTHING = Broken()


class SourceMap(NamedTuple):
    """A document's file, lines and places.

    Paths into the document are sequences of keys and indices. Steps that the text does not have,
    such as the tags that unions add, are passed over.

    Attributes:
        path: the file.
        lines: its text.
        root: its values.
        broken: what is faulty and was left out of ``root``.
    """

    path: Path
    lines: Sequence[str]
    root: Node
    broken: Broken = _NOTHING

    def is_whole(self, *steps: Step) -> bool:
        """Whether nothing was left out at, above or below a path."""
        return not self.broken.touches(steps)

    def declared(self, entries: Mapping[str, T], *section: Step) -> Declared[T]:
        """The entries of a section, together with those that were left out of it."""
        return Declared(entries, self.broken, section)

    def place(self, *steps: Step) -> Place:
        """Where the value at a path stands, or what encloses it where it is absent."""
        return self.node(steps).place

    def key(self, *steps: Step) -> Place:
        """Where the key at a path stands, or what encloses it where it is absent."""
        parent = self.node(steps[:-1])
        return parent.keys.get(str(steps[-1]), parent.place) if steps else parent.place

    def inside(self, steps: Sequence[Step], start: int, end: int) -> Place:
        """Where a stretch of a text value stands; columns within it from 1, ``end`` exclusive."""
        node = self.node(steps)
        place, value = node.place, node.value
        if not isinstance(value, str):
            return place
        line = self.lines[place.line - 1]
        offset = line[place.column - 1 : place.end_column - 1].find(value)
        if offset >= 0:
            column = place.column + offset - 1
            return Place(place.file, place.line, column + start, column + end)
        return self._in_lines(place, value, start, end) or place

    def _in_lines(self, place: Place, value: str, start: int, end: int) -> Place | None:
        """Where a stretch of a text of several lines stands; YAML joins them with spaces."""
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
        """Line, column and character of what is written from a place on, but for spaces."""
        opening = self.lines[place.line - 1][place.column - 1 : place.column]
        # A text of a block, as after `>-`, begins on the line below, a quoted one behind its quote.
        below = opening in (">", "|")
        skipped = 0 if below else place.column - 1 + (opening in ("'", '"'))
        for row in range(place.line + below, len(self.lines) + 1):
            for column, character in enumerate(self.lines[row - 1][skipped:], skipped + 1):
                if not character.isspace():
                    yield row, column, character
            skipped = 0

    def node(self, steps: Sequence[Step]) -> Node:
        """The deepest node along a path."""
        node = self.root
        for step in steps:
            node = child_of(node, step) or node
        return node

    def written(self, node: Node) -> str:
        """A value in brackets, with its texts and numbers as they are written."""
        if isinstance(node.value, dict):
            return f"{{{', '.join(f'{k}: {self.written(v)}' for k, v in node.value.items())}}}"
        if isinstance(node.value, list):
            return f"[{', '.join(map(self.written, node.value))}]"
        place = node.place
        return self.lines[place.line - 1][place.column - 1 : place.end_column - 1].strip()

    def holds(self, *steps: Step) -> bool:
        """Whether the text itself gives a value at a path, instead of a default doing so."""
        node: Node | None = self.root
        for step in steps:
            node = child_of(node, step) if node else None
        return node is not None


def child_of(node: Node, step: Step) -> Node | None:
    """A mapping's value or a sequence's item, or ``None``."""
    if isinstance(node.value, dict):
        return node.value.get(str(step))
    if isinstance(node.value, list) and isinstance(step, int) and step < len(node.value):
        return node.value[step]
    return None
