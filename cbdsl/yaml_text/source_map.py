"""Where every value of a document stands in its text."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from cbdsl.errors.diagnostic import Place
from cbdsl.yaml_text.node import Node

Step = str | int


class SourceMap(NamedTuple):
    """A document's file, lines and places.

    Paths into the document are sequences of keys and indices. Steps that the text does not have,
    such as the tags that unions add, are passed over.
    """

    path: Path
    lines: Sequence[str]
    root: Node

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
        line = self.lines[place.line - 1]
        written = line[place.column - 1 : place.end_column - 1]
        offset = written.find(value) if isinstance(value, str) else -1
        if offset < 0:
            return place
        column = place.column + offset - 1
        return Place(place.file, place.line, column + start, column + end)

    def node(self, steps: Sequence[Step]) -> Node:
        """The deepest node along a path."""
        node = self.root
        for step in steps:
            node = child_of(node, step) or node
        return node

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
