"""From YAML text to nodes, within bounds, with every trap as a located finding.

It builds on libyaml's events instead of its nodes: the parser keeps its own stack and survives any
depth, while libyaml's composer recurses, and crashes the process on deep input.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import yaml

from cbdsl.errors.diagnostic import Diagnostic, Place
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.errors.lines import lines_of
from cbdsl.errors.wording import diagnostic
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.scalar import ScalarError, resolve
from cbdsl.yaml_text.syntax import find_slip

DEEPEST = 64
# Far more than any person writes; without bounds a few lines can keep the checker busy for ever.
MOST_NODES = 10_000
MOST_ENTRIES = 2_000
MOST_CHARACTERS = 256_000
LONGEST_TEXT = 10_000

# What libyaml says where it noticed too late.
_OPEN = "found unexpected end of stream"
_OPENED = {
    "did not find expected ',' or ']'": ("[", "]"),
    "did not find expected ',' or '}'": ("{", "}"),
}
_LATE = ("could not find expected ':'", _OPEN)

LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
# What YAML 1.2 excludes (5.1); C1 controls but NEL, and what is no character at all.
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff]")
# Characters of no width, byte order marks, and those that turn the direction of writing.
_INVISIBLE = re.compile(r"[\u200b\u200e\u200f\u202a-\u202e\u2060\u2066-\u2069\ufeff]")


class Composed(NamedTuple):
    """The one document of a YAML text.

    Attributes:
        root: all of its values; those with a finding are marked as faulty.
        findings: what is wrong with single values.
    """

    root: Node
    findings: tuple[Diagnostic, ...]


def compose(text: str, file: str) -> Composed:
    """The one document of a YAML text.

    Raises:
        DiagnosticsError: with every finding up to the first one that hides the rest.
    """
    if len(text) > MOST_CHARACTERS:
        bound = f"{MOST_CHARACTERS} characters"
        raise DiagnosticsError([diagnostic("CB108", Place(file), bound=bound)])
    control = _CONTROL.search(text)
    if control:
        raise DiagnosticsError([_unseen("CB103", control, file)])
    # One stands for all: they tend to come in swarms.
    invisible = [_unseen("CB118", m, file) for m in [_INVISIBLE.search(text)] if m]
    composer = _Composer(text, file)
    try:
        root = composer.document()
    except DiagnosticsError as error:
        # What is no YAML is so because of them.
        rest = [d for d in error.diagnostics if not (invisible and d.code == "CB104")]
        raise DiagnosticsError([*invisible, *rest]) from None
    if invisible:
        raise DiagnosticsError([*invisible, *composer.findings])
    return Composed(root, tuple(composer.findings))


def _unseen(code: str, match: re.Match[str], file: str) -> Diagnostic:
    """A finding about a character that no editor shows."""
    before = lines_of(match.string[: match.start()])
    place = Place(file, len(before), len(before[-1]) + 1, len(before[-1]) + 2)
    return diagnostic(code, place, character=f"U+{ord(match[0]):04X}")


class _Composer:
    """Events to nodes; findings gather in ``findings`` and only a broken text stops it."""

    def __init__(self, text: str, file: str) -> None:
        self.findings: list[Diagnostic] = []
        self._text = text
        self._file = file
        self._loader = LOADER(text)
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
            raise self._fatal("CB119", place, bound=DEEPEST)
        return node

    def _alias(self, event: Any, place: Place) -> Node:
        if event.anchor not in self._anchors:
            raise self._fatal("CB111", place, name=event.anchor)
        node = self._anchors[event.anchor]
        self._count(node.weight, place)
        return node

    def _fresh(self, event: Any, place: Place, depth: int) -> Node:
        self._count(1, place)
        node = Node(place, None)
        if event.tag is not None and event.tag != "!":
            written = event.tag.replace("tag:yaml.org,2002:", "!!")
            self._find("CB112", place, tag=written)
            node.faulty = True
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(node, event)
            return node
        if depth > DEEPEST:
            raise self._fatal("CB119", place, bound=DEEPEST)
        if isinstance(event, yaml.SequenceStartEvent):
            node.value = list(self._items(depth))
        else:
            self._fill(node, depth)
        for child in node.children():
            node.weight += child.weight
            node.height = max(node.height, child.height + 1)
        return node

    def _scalar(self, node: Node, event: Any) -> None:
        text: str = event.value
        node.value = text
        if len(text) > LONGEST_TEXT:
            bound = f"{LONGEST_TEXT} characters in one text"
            raise self._fatal("CB108", node.place, bound=bound)
        if not event.implicit[0]:
            return
        try:
            node.value = resolve(text)
        except ScalarError as error:
            self._find(error.code, node.place, text=text)
            node.faulty = True

    def _items(self, depth: int) -> Iterator[Node]:
        entries = 0
        while not isinstance(event := self._next(), yaml.SequenceEndEvent):
            yield self._node(event, depth + 1)
            entries = self._one_more(entries, event)

    def _fill(self, node: Node, depth: int) -> None:
        values: dict[str, Node] = {}
        entries = 0
        while not isinstance(event := self._next(), yaml.MappingEndEvent):
            place = self._place(event)
            entries = self._one_more(entries, event)
            # A key is its text as written: 10 and X- are both patterns of a state.
            key = event.value if isinstance(event, yaml.ScalarEvent) else None
            if key is None:
                self._find("CB113", place)
                node.faulty = True
                self._node(event, depth + 1)
            value = self._node(self._next(), depth + 1)
            if key in values:
                first = (node.keys[key], "first written here")
                self._find("CB107", place, related=[first], key=key)
                values[key].faulty = True
            elif key is not None:
                values[key], node.keys[key] = value, place
        node.value = values

    def _one_more(self, entries: int, event: Any) -> int:
        """The entries of a list or mapping with the one that begins here."""
        if entries == MOST_ENTRIES:
            bound = f"{MOST_ENTRIES} entries of one list or mapping"
            raise self._fatal("CB108", self._place(event), bound=bound)
        return entries + 1

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
        # A key that lacks its colon is noticed only on the next line, an open quote at the end.
        lost = error.context_mark if problem.endswith(_LATE) else None
        if problem == _OPEN:
            problem = "this quote is never closed"
        mark = lost or error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        if self._is_tab(line, column):
            return self._fatal("CB117", Place(self._file, line, column, column + 1))
        if "scanning an alias" in (error.context or ""):
            problem = "'*' is followed by no name; text that begins with it is quoted, as in \"**\""
        related = []
        if error.problem and error.context and error.context_mark and not lost:
            start = error.context_mark
            place = Place(self._file, start.line + 1, start.column + 1, start.column + 2)
            related.append((place, error.context))
        if slip := find_slip(problem, lines_of(self._text), line, column):
            problem, line, column = slip
        elif problem in _OPENED and error.context_mark:
            opening, closing = _OPENED[problem]
            where = f"the '{opening}' in line {error.context_mark.line + 1}"
            problem = f"a ',' is missing before this, or the '{closing}' of {where}"
        place = Place(self._file, line, column, column + 1)
        return self._fatal("CB104", place, related=related, problem=problem)

    def _is_tab(self, line: int, column: int) -> bool:
        rows = lines_of(self._text)
        return line <= len(rows) and rows[line - 1][column - 1 : column] == "\t"
