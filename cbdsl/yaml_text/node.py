"""Values of a YAML text, each with its place."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.yaml_text.scalar import Scalar


class Node:
    """Scalar, sequence or mapping with its place.

    Attributes:
        place: First line of the value; for a scalar in one line, up to its end.
        value: Scalar, items of a sequence, or values of a mapping by key.
        keys: Places of a mapping's keys.
        faulty: True if no document can hold this value.
        weight: Number of nodes, with aliases expanded.
        height: Levels of nesting below the node.
        written: Text of a plain scalar, which its value may have lost: -0 is the integer 0.
    """

    __slots__ = ("faulty", "height", "keys", "place", "value", "weight", "written")

    def __init__(self, place: Place, value: Scalar | list[Node] | dict[str, Node]) -> None:
        self.place = place
        self.value = value
        self.keys: dict[str, Place] = {}
        self.faulty = False
        self.weight = 1
        self.height = 0
        self.written = ""

    def children(self) -> Iterator[Node]:
        """Yield the items or values, in order."""
        if isinstance(self.value, dict):
            yield from self.value.values()
        elif isinstance(self.value, list):
            yield from self.value

    def steps(self) -> Iterator[tuple[str | int, Node]]:
        """Yield items with their indices, or values with their keys, in order."""
        if isinstance(self.value, dict):
            yield from self.value.items()
        elif isinstance(self.value, list):
            yield from enumerate(self.value)

    def texts(
        self, path: tuple[str | int, ...] = ()
    ) -> Iterator[tuple[tuple[str | int, ...], Node]]:
        """Yield the texts at and below a path to this node, each with its path."""
        if isinstance(self.value, str):
            yield path, self
        for step, child in self.steps():
            yield from child.texts((*path, step))

    def drop(self, step: str | int) -> None:
        """Remove the value of a key or the item at an index, if it exists."""
        if isinstance(self.value, dict):
            self.value.pop(str(step), None)
            self.keys.pop(str(step), None)
        elif isinstance(self.value, list) and isinstance(step, int) and step < len(self.value):
            del self.value[step]

    def plain(self) -> object:
        """Return the value as dicts, lists and scalars."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value
