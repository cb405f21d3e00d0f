"""Bounded composition of YAML text into nodes, with a located diagnostic for every pitfall.

It builds on libyaml's events instead of its nodes: the parser keeps its own stack and survives any
depth, while libyaml's composer recurses, and crashes the process on deep input.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import yaml

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.lines import lines_of
from cbdsl.diagnostics.wording import diagnose
from cbdsl.yaml_text.characters import (
    control_in,
    look_alike_message,
    spelled,
    suggested_key,
    suggested_value,
)
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.scalar import ScalarError, resolve

if TYPE_CHECKING:
    from cbdsl.yaml_text.comma import Stray

DEEPEST = 64
# Far above the size of any document; without bounds, a few lines could block the checker.
MOST_NODES = 10_000
MOST_ENTRIES = 2_000
MOST_CHARACTERS = 256_000
LONGEST_TEXT = LONGEST_LINE = 10_000
LONGEST_KEY = 1_000
#: Largest size in bytes of a text of that many characters, including a byte order mark.
MOST_BYTES = 4 * MOST_CHARACTERS + 3

LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class Composed(NamedTuple):
    """Single document of a YAML text.

    Attributes:
        root: Root of all values; values with a diagnostic are marked as faulty.
        diagnostics: Diagnostics about single values.
        lines: Lines of the text.
    """

    root: Node
    diagnostics: tuple[Diagnostic, ...]
    lines: Sequence[str]


class YamlSyntaxError(Exception):
    """Text that is not valid YAML.

    Attributes:
        error: Error of libyaml.
        diagnostics: Diagnostics in the text up to the error.
    """

    def __init__(self, error: yaml.MarkedYAMLError, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__(str(error))
        self.error = error
        self.diagnostics = diagnostics


def compose(text: str, file: str) -> Composed:
    """Compose the single document of a YAML text, without repairs.

    Raises:
        DiagnosticsError: A fatal diagnostic, together with all diagnostics up to it.
        YamlSyntaxError: The text is not valid YAML.
    """
    require_readable(text, file)
    composer = _Composer(text, file)
    try:
        root = composer.document()
    except yaml.MarkedYAMLError as error:
        raise YamlSyntaxError(error, composer.diagnostics) from None
    return Composed(root, tuple(composer.diagnostics), composer.lines)


def require_readable(text: str, file: str) -> None:
    """Refuse a text that is too long or holds control characters.

    Raises:
        DiagnosticsError: The text is refused.
    """
    if len(text) > MOST_CHARACTERS:
        raise too_large(file)
    if control := control_in(text):
        raise DiagnosticsError([unseen("CB103", control, file)])


def require_short_lines(text: str, file: str) -> None:
    """Refuse broken YAML with lines so long that the search for the mistake would be slow.

    Raises:
        DiagnosticsError: A line is too long.
    """
    for number, line in enumerate(lines_of(text), 1):
        if len(line) > LONGEST_LINE:
            place = Place(file, number, 1, 2)
            bound = f"{LONGEST_LINE} characters in one line"
            raise DiagnosticsError([diagnose("CB108", place, bound=bound)])


def too_large(file: str) -> DiagnosticsError:
    """Return the error for a text that is too long."""
    bound = f"{MOST_CHARACTERS} characters"
    return DiagnosticsError([diagnose("CB108", Place(file), bound=bound)])


def unseen(code: str, match: re.Match[str], file: str) -> Diagnostic:
    """Return a diagnostic about an invisible character."""
    before = lines_of(match.string[: match.start()])
    place = Place(file, len(before), len(before[-1]) + 1, len(before[-1]) + 2)
    return diagnose(code, place, character=spelled(match[0]))


#: Key that adds the entries of another mapping (YAML 1.1).
MERGE = "<<"


# Aliases share nodes, so that a text of a few lines can stand for billions of values. Each node
# therefore has the weight and the height that it has with all aliases expanded. They are known as
# soon as the node is complete, and bound the document before anything walks through it. The
# recursion is bounded, too, because events inside a value that is too deep are not composed.
class _Composer:
    """Composer of nodes from events; it collects ``diagnostics`` and stops only at fatal ones."""

    def __init__(self, text: str, file: str) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.lines = lines_of(text)
        self._file = file
        self._next: Callable[[], Any] = LOADER(text).get_event
        self._anchors: dict[str, Node] = {}
        self._nodes = 0

    def document(self) -> Node:
        self._next()
        # A text only of comments ends here, without the start of a document.
        if isinstance(self._next(), yaml.StreamEndEvent):
            raise self._fatal("CB105", Place(self._file))
        root = self._node(self._next(), 0)
        self._next()
        event = self._next()
        if not isinstance(event, yaml.StreamEndEvent):
            raise self._fatal("CB106", self._place(event, 3))
        return root

    def _node(self, event: Any, depth: int) -> Node:
        place = self._place(event)
        if isinstance(event, yaml.AliasEvent):
            node = self._alias(event, place)
        else:
            node = self._fresh(event, place, depth)
            if event.anchor:
                # The anchor counts from the end of its value on. An alias inside that value is thus
                # undefined, and nodes never form a circle.
                self._anchors[event.anchor] = node
        if depth + node.height > DEEPEST:
            raise self._fatal("CB119", place, bound=DEEPEST)
        return node

    def _alias(self, event: Any, place: Place) -> Node:
        node = self._anchors.get(event.anchor)
        if node is None:
            self._find("CB111", place, names=list(self._anchors), name=event.anchor)
            node = Node(place, None)
            node.faulty = True
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
            if event.flow_style:
                self._rejoin(node.value)
        else:
            self._fill(node, depth)
        for child in node.children():
            node.weight += child.weight
            node.height = max(node.height, child.height + 1)
        return node

    def _scalar(self, node: Node, event: Any) -> None:
        text: str = event.value
        if len(text) > LONGEST_TEXT:
            bound = f"{LONGEST_TEXT} characters in one text"
            raise self._fatal("CB108", node.place, bound=bound)
        is_plain: bool = event.implicit[0]
        if is_plain and not text.isascii() and (suggestion := suggested_value(text)):
            self._find("CB123", node.place, problem=look_alike_message(text, suggestion))
            text = suggestion
        node.value = text
        if not is_plain:
            return
        if event.anchor and not text:
            problem = f"a text that begins with '&' must be quoted; write '&{event.anchor}'"
            self._find("CB124", node.place, problem=problem)
            node.faulty = True
        node.written = text
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

    def _rejoin(self, items: list[Node]) -> None:
        """Join the calls in brackets that commas split."""
        if not any("(" in item.written for item in items):
            return
        from cbdsl.yaml_text.comma import split_calls  # few lists have calls

        for call in reversed(list(split_calls(items))):
            first, last = items[call.first], items[call.first + call.rest]
            self._find("CB205", first.place, problem=call.problem)
            if isinstance(last.value, dict):
                part, *_ = last.value
                last.value = {call.text if key == part else key: v for key, v in last.value.items()}
                last.keys = {call.text if key == part else key: p for key, p in last.keys.items()}
                first = last
            else:
                first.value = first.written = call.text
                first.faulty = call.is_open
            items[call.first : call.first + call.rest + 1] = [first]

    def _fill(self, node: Node, depth: int) -> None:
        values: dict[str, Node] = {}
        strays: dict[str, list[Stray]] = {}
        entries = 0
        merges = False
        while not isinstance(event := self._next(), yaml.MappingEndEvent):
            place = self._place(event)
            entries = self._one_more(entries, event)
            key = self._key(event, place)
            merges |= key == MERGE and event.implicit[0]  # a quoted one is an ordinary key
            if key is None:
                self._find("CB113", place)
                node.faulty = True
                # The events of the key are consumed, so that its value comes next.
                self._node(event, depth + 1)
            value = self._node(self._next(), depth + 1)
            if key is None:
                continue
            if value.value is None and (stray := self._stray(key, place, values, strays)):
                strays.setdefault(next(reversed(values)), []).append(stray)
            elif key in values:
                first = (node.keys[key], "first written here")
                self._find("CB107", place, related=[first], key=key)
                values[key].faulty = True
            else:
                values[key], node.keys[key] = value, place
        for key, pieces in strays.items():
            self._join(key, values[key], pieces)
        node.value = values
        if merges and (merged := values.pop(MERGE, None)) is not None:
            self._merge(node, values, merged)

    def _merge(self, node: Node, values: dict[str, Node], merged: Node) -> None:
        """Add the entries of other mappings whose keys a mapping lacks.

        Args:
            node: Mapping with the merge key.
            values: Entries of the mapping.
            merged: Value of the merge key: a mapping, or a list of mappings, the first one ahead.
        """
        place = node.keys.pop(MERGE)
        for source in merged.value if isinstance(merged.value, list) else [merged]:
            if not isinstance(source.value, dict):
                if not (source.faulty or merged.faulty):
                    self._find("CB125", place)
                node.faulty = True
                continue
            for key, value in source.value.items():
                if key not in values:
                    self._count(value.weight, place)
                    values[key], node.keys[key] = value, source.keys[key]
            node.faulty |= source.faulty

    def _stray(
        self, key: str, place: Place, values: dict[str, Node], strays: dict[str, list[Stray]]
    ) -> Stray | None:
        """Return the text in the place of a key, if a comma split it from the value before it."""
        from cbdsl.yaml_text.comma import Stray, is_stray  # only a key without a value needs it

        if not values:
            return None
        last = next(reversed(values))
        before = [values[last].written, *(stray.text for stray in strays.get(last, ()))]
        behind = self.lines[place.line - 1][place.end_column - 1 :]
        return Stray(key, place) if is_stray(key, behind, before) else None

    def _join(self, key: str, value: Node, strays: list[Stray]) -> None:
        """Join a value that commas split; mark it as faulty if its whole is ambiguous."""
        from cbdsl.yaml_text.comma import explain  # only a fault needs it

        cut = explain(key, value, strays)
        self._find("CB205", value.place, problem=cut.problem)
        if cut.whole is None:
            value.faulty = True
        else:
            value.value = resolve(cut.whole)
            end = strays[-1].place
            if end.line == value.place.line:
                value.place = value.place._replace(end_column=end.end_column)

    def _key(self, event: Any, place: Place) -> str | None:
        """Return the text of a key as written, because 10 and X- are both patterns of a state."""
        if isinstance(event, yaml.AliasEvent):
            key = f"*{event.anchor}"
            problem = f"a key that begins with '*' must be quoted; write '{key}'"
            self._find("CB124", place, problem=problem)
            return key
        if not isinstance(event, yaml.ScalarEvent):
            return None
        text: str = event.value
        if len(text) > LONGEST_KEY:
            bound = f"{LONGEST_KEY} characters in one key"
            raise self._fatal("CB108", place, bound=bound)
        if event.implicit[0] and not text.isascii() and (suggestion := suggested_key(text)):
            self._find("CB123", place, problem=look_alike_message(text, suggestion))
            return suggestion
        return text

    def _one_more(self, entries: int, event: Any) -> int:
        """Return the number of entries including the entry that begins at an event."""
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
        # Marks count from 0. An empty scalar has no width, and still covers one column here.
        is_short = isinstance(event, (yaml.ScalarEvent, yaml.AliasEvent)) and line == end.line
        end_column = max(end.column + 1, column + 1) if is_short else column + width
        return Place(self._file, line + 1, column, end_column)

    def _find(self, code: str, place: Place, **details: Any) -> None:
        self.diagnostics.append(diagnose(code, place, **details))

    def _fatal(self, code: str, place: Place, **details: Any) -> DiagnosticsError:
        return DiagnosticsError([*self.diagnostics, diagnose(code, place, **details)])
