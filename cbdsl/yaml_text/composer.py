"""From YAML text to nodes, within bounds, with every trap as a located finding.

It builds on libyaml's events instead of its nodes: the parser keeps its own stack and survives any
depth, while libyaml's composer recurses, and crashes the process on deep input.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import yaml

from cbdsl.errors.diagnostic import Diagnostic, Place
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.errors.wording import diagnostic
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.scalar import Scalar, ScalarError, resolve

DEEPEST = 64
MOST_NODES = 100_000

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
# What YAML 1.2 excludes (5.1); C1 controls but NEL, and what is no character at all.
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff]")


def compose(text: str, file: str) -> Node:
    """The one document of a YAML text.

    Raises:
        DiagnosticsError: with every finding up to the first one that hides the rest.
    """
    control = _CONTROL.search(text)
    if control:
        line = text.count("\n", 0, control.start()) + 1
        column = control.start() - text.rfind("\n", 0, control.start())
        place = Place(file, line, column, column + 1)
        raise DiagnosticsError([diagnostic("CB103", place, character=f"U+{ord(control[0]):04X}")])
    composer = _Composer(text, file)
    root = composer.document()
    if composer.findings:
        raise DiagnosticsError(composer.findings)
    return root


class _Composer:
    """Events to nodes; findings gather in ``findings`` and only a broken text stops it."""

    def __init__(self, text: str, file: str) -> None:
        self.findings: list[Diagnostic] = []
        self._text = text
        self._file = file
        self._loader = _LOADER(text)
        self._anchors: dict[str, Node] = {}
        self._nodes = 0

    def document(self) -> Node:
        self._next()
        if isinstance(self._next(), yaml.StreamEndEvent):
            raise self._fatal("CB105", Place(self._file))
        root = self._node(self._next(), 0)
        self._next()
        event = self._next()
        if not isinstance(event, yaml.StreamEndEvent):
            raise self._fatal("CB106", self._place(event, 3))
        return root

    def _next(self) -> Any:
        try:
            return self._loader.get_event()
        except yaml.MarkedYAMLError as error:
            raise self._syntax_error(error) from None

    def _node(self, event: Any, depth: int) -> Node:
        place = self._place(event)
        if isinstance(event, yaml.AliasEvent):
            node = self._alias(event, place)
        else:
            node = self._fresh(event, place, depth)
            if event.anchor:
                self._anchors[event.anchor] = node
        if depth + node.height > DEEPEST:
            raise self._fatal("CB108", place, bound=f"{DEEPEST} levels deep")
        return node

    def _alias(self, event: Any, place: Place) -> Node:
        if event.anchor not in self._anchors:
            raise self._fatal("CB111", place, name=event.anchor)
        node = self._anchors[event.anchor]
        self._count(node.weight, place)
        return node

    def _fresh(self, event: Any, place: Place, depth: int) -> Node:
        self._count(1, place)
        if event.tag is not None and event.tag != "!":
            self._find("CB112", place, tag=event.tag)
        if isinstance(event, yaml.ScalarEvent):
            return Node(place, self._scalar(event, place))
        if depth > DEEPEST:
            raise self._fatal("CB108", place, bound=f"{DEEPEST} levels deep")
        node = Node(place, None)
        if isinstance(event, yaml.SequenceStartEvent):
            node.value = list(self._items(depth))
        else:
            self._fill(node, depth)
        for child in node.children():
            node.weight += child.weight
            node.height = max(node.height, child.height + 1)
        return node

    def _scalar(self, event: Any, place: Place) -> Scalar:
        text: str = event.value
        if not event.implicit[0]:
            return text
        try:
            return resolve(text)
        except ScalarError as error:
            self._find(error.code, place, text=text)
            return text

    def _items(self, depth: int) -> Iterator[Node]:
        while not isinstance(event := self._next(), yaml.SequenceEndEvent):
            yield self._node(event, depth + 1)

    def _fill(self, node: Node, depth: int) -> None:
        values: dict[str, Node] = {}
        while not isinstance(event := self._next(), yaml.MappingEndEvent):
            place = self._place(event)
            # A key is its text as written: 10 and X- are both patterns of a state.
            key = event.value if isinstance(event, yaml.ScalarEvent) else None
            if key is None:
                self._find("CB113", place)
                self._node(event, depth + 1)
            value = self._node(self._next(), depth + 1)
            if key in values:
                first = (node.keys[key], "first written here")
                self._find("CB107", place, related=[first], key=key)
            elif key is not None:
                values[key], node.keys[key] = value, place
        node.value = values

    def _count(self, nodes: int, place: Place) -> None:
        self._nodes += nodes
        if self._nodes > MOST_NODES:
            raise self._fatal("CB108", place, bound=f"{MOST_NODES} values")

    def _place(self, event: Any, width: int = 1) -> Place:
        start, end = event.start_mark, event.end_mark
        line, column = start.line, start.column + 1
        is_short = isinstance(event, (yaml.ScalarEvent, yaml.AliasEvent)) and line == end.line
        end_column = max(end.column + 1, column + 1) if is_short else column + width
        return Place(self._file, line + 1, column, end_column)

    def _find(self, code: str, place: Place, **details: Any) -> None:
        self.findings.append(diagnostic(code, place, **details))

    def _fatal(self, code: str, place: Place, **details: Any) -> DiagnosticsError:
        return DiagnosticsError([*self.findings, diagnostic(code, place, **details)])

    def _syntax_error(self, error: yaml.MarkedYAMLError) -> DiagnosticsError:
        problem = error.problem or error.context or "no YAML"
        # A key that lacks its colon is noticed only on the next line.
        lost = "could not find expected ':'" in problem and error.context_mark
        mark = lost or error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        if self._is_tab(line, column):
            problem = "a tab; lines are indented with spaces"
        elif "scanning an alias" in (error.context or ""):
            problem = "'*' is followed by no name; text that begins with it is quoted, as in \"**\""
        related = []
        if error.problem and error.context and error.context_mark and not lost:
            start = error.context_mark
            place = Place(self._file, start.line + 1, start.column + 1, start.column + 2)
            related.append((place, error.context))
        place = Place(self._file, line, column, column + 1)
        return self._fatal("CB104", place, related=related, problem=problem)

    def _is_tab(self, line: int, column: int) -> bool:
        rows = self._text.split("\n")
        return line <= len(rows) and rows[line - 1][column - 1 : column] == "\t"
