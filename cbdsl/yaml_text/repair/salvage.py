"""From a text with faults to a document of what is left without them.

One fault must not hide the others: what is faulty is left out of the nodes, as a whole controller,
thing or row, and the rest is validated again. What was left out is remembered, so that nothing is
said to be missing because of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_of
from cbdsl.errors.diagnostic import Diagnostic, Place
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.errors.nearest import nearest_name
from cbdsl.yaml_text.broken import Broken
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.faults import faults, path_of
from cbdsl.yaml_text.repair.misplaced import find_moves, move
from cbdsl.yaml_text.repair.shape import SchemaShape
from cbdsl.yaml_text.source_map import SourceMap, Step
from cbdsl.yaml_text.unknown import UNKNOWN

Steps = tuple[Step, ...]

# Of a word that YAML 1.1 takes for true or false.
_WORD = "CB114"
# Each round leaves out what encloses the faults of the one before.
_MOST_ROUNDS = 12

D = TypeVar("D", bound=Document)


def salvage(source: SourceMap, model: type[D], findings: Iterable[Diagnostic]) -> Loaded[D]:
    """Read a document from its nodes, from which faulty ones are taken away.

    Args:
        source: the text, whose nodes change.
        model: the kind of document.
        findings: what is wrong with the values that are marked as faulty.

    Raises:
        DiagnosticsError: nothing that could be checked is left.
    """
    return _Salvage(source, model, findings).salvage()


class _Salvage(Generic[D]):
    def __init__(self, source: SourceMap, model: type[D], findings: Iterable[Diagnostic]) -> None:
        self._source = source
        self._model = model
        self._faults = list(findings)
        self._broken = Broken()
        self._respelt: set[Steps] = set()
        self._unknown: dict[str, object] = {}
        self._context = {"folder": source.path.parent}

    def salvage(self) -> Loaded[D]:
        if self._faults:
            self._judge_words()
            self._leave_out(_faulty(self._source.root, ()))
        for _ in range(_MOST_ROUNDS):
            try:
                document = self._validated()
            except ValidationError as error:
                self._mend(error.errors(include_url=False))
            else:
                document = document.model_copy(update=self._unknown)
                source = self._source._replace(broken=self._broken)
                return Loaded(document, source, tuple(self._faults))
        raise self._hopeless()

    def _validated(self) -> D:
        return self._model.model_validate(self._source.root.plain(), context=self._context)

    def _judge_words(self) -> None:
        """Take words such as ``off`` for texts where no text is wanted: what is says more.

        To put them in quotes is a remedy only where a text may be.
        """
        words = {finding.place for finding in self._faults if finding.code == _WORD}
        if not words:
            return
        wrong = {path_of(error, self._source) for error in self._errors()}
        places = set()
        for path in _faulty(self._source.root, ()):
            node = self._source.node(path)
            if path in wrong and node.place in words:
                node.faulty = False
                places.add(node.place)
        self._faults = [
            each for each in self._faults if each.code != _WORD or each.place not in places
        ]

    def _errors(self) -> list[ErrorDetails]:
        try:
            self._validated()
        except ValidationError as error:
            return error.errors(include_url=False)
        return []

    def _mend(self, errors: list[ErrorDetails]) -> None:
        """Report what is wrong, and take it away."""
        located = [(path_of(error, self._source), error) for error in errors]
        if moves := find_moves(self._source, self._model, [path for path, _ in located]):
            # What else is wrong is found where these keys are in their places.
            self._faults += [move(self._source, moved) for moved in moves]
            return
        self._faults += faults(errors, self._source, self._model, self._follows)
        # Where something inside is wrong as well, the whole may be right without that.
        outer = {path[:depth] for path, _ in located for depth in range(len(path))}
        wrong = [p for p, e in located if e["type"] != "missing" and p not in outer]
        unknown = {path: e["loc"] for path, e in located if e["type"] == "extra_forbidden"}
        respelt = {path for path, loc in unknown.items() if self._respell(path, loc)}
        missing = {path for path, error in located if error["type"] == "missing"} - self._respelt
        self._leave_out([path for path in wrong if path not in respelt])
        self._leave_out([path[:-1] for path in missing if len(path) > 1])
        for path in missing:
            if len(path) == 1:
                self._stand_in(str(path[0]))

    def _follows(self, path: Steps, kind: str) -> bool:
        """Whether a fault is there only because of another."""
        if kind == "extra_forbidden":
            return False
        return path in self._respelt or self._broken.is_below(path)

    def _respell(self, path: Steps, loc: Steps) -> bool:
        """Put a value under the key that was probably meant; whether there is one."""
        parent, key = self._source.node(path[:-1]), str(path[-1])
        if not isinstance(parent.value, dict) or key not in parent.value:
            return False
        shape = SchemaShape((self._model,)).located(loc[:-1])
        free = sorted(shape.keys.keys() - parent.value)
        new = shape.renamed.get(key)
        suggestion = nearest_name(key, free) if new is None else new if new in free else None
        if suggestion is not None:
            parent.value[suggestion], parent.keys[suggestion] = (
                parent.value.pop(key),
                parent.keys.pop(key),
            )
            self._respelt.add((*path[:-1], suggestion))
        return suggestion is not None

    def _leave_out(self, paths: Iterable[Steps]) -> None:
        """Take the parts of the document away that paths lead to."""
        parts = {_part(path, self._model) for path in paths}
        # Of a list the last items go first: the others keep their places until then.
        for part in sorted(parts, key=lambda part: [str(step).zfill(9) for step in part])[::-1]:
            if not part:
                raise self._hopeless()
            self._source.node(part[:-1]).drop(part[-1])
            # In `track {gain: 3}`, `{arm right_arm}` or `models:{pan: head}` the key comes first.
            self._broken.add([part, (*part[:-1], re.split("[ :{]", str(part[-1]))[0])])

    def _stand_in(self, key: str) -> None:
        root = self._source.root
        # They take the place of required values; checks do not look at them.
        stand_ins = {"name": "unknown", **kind_of(self._model).stand_ins}
        if key not in stand_ins or not isinstance(root.value, dict):
            raise self._hopeless()
        root.value[key] = _node(stand_ins[key], root.place)
        self._broken.add([(key,)])
        if stand_ins[key] == "unknown":
            self._unknown[key] = UNKNOWN
        elif stand_ins[key] == ["unknown"]:
            self._unknown[key] = ()

    def _hopeless(self) -> DiagnosticsError:
        return DiagnosticsError(self._faults)


def _faulty(node: Node, path: Steps) -> Iterator[Steps]:
    """Paths of the nodes that are no part of any document."""
    if node.faulty:
        yield path
    for step, child in node.steps():
        yield from _faulty(child, (*path, step))


def _part(path: Steps, model: type[BaseModel]) -> Steps:
    """The first entry of a list or of names along a path, or all of it.

    What else is in the entry makes no sense without what is faulty.
    """
    for depth, step in enumerate(path):
        field = model.model_fields.get(str(step))
        if field is None:
            return path[: depth + 1]
        inner = field.annotation
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return path[: depth + 2]
        model = inner
    return path


def _node(value: Any, place: Place) -> Node:
    """A value as if it stood at a place."""
    if isinstance(value, dict):
        return Node(place, {key: _node(inner, place) for key, inner in value.items()})
    if isinstance(value, list):
        return Node(place, [_node(inner, place) for inner in value])
    return Node(place, value)
