"""Reading of the sound parts of a document with faults.

One fault must not hide the others. A faulty entry, such as a controller, an object or a row, is
removed from the nodes, and the rest is validated again. Removed parts are recorded, so that they
are not reported as missing.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.diagnostics.outcome import UNKNOWN
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_of
from cbdsl.yaml_text.broken import Broken
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.invalid_values import diagnostics_of, path_of
from cbdsl.yaml_text.repair.misplaced import find_moves, move
from cbdsl.yaml_text.repair.schema_shape import SchemaShape
from cbdsl.yaml_text.source_map import SourceMap, Step

Steps = tuple[Step, ...]

# Code of a word that YAML 1.1 takes for true or false.
_WORD = "CB114"
# Each round removes the parts that enclose the faults of the previous round.
_MOST_ROUNDS = 12

D = TypeVar("D", bound=Document)


def salvage(
    source: SourceMap,
    model: type[D],
    diagnostics: Iterable[Diagnostic],
    errors: Sequence[ErrorDetails] = (),
) -> Loaded[D]:
    """Read a document from its nodes, after removal of the faulty ones.

    The document is validated once more after each round of removals. A part that is incomplete
    without a removed one is removed with it, so that one round suffices for faults in their places.
    Faults in several layers need several rounds. pydantic reports no error inside a value of a
    wrong form, and a moved or respelt key is validated only in its new place.

    Args:
        source: Source map of the document; its nodes are modified.
        model: Model of the kind of document.
        diagnostics: Diagnostics about the values that are marked as faulty.
        errors: Errors of the nodes, if they are already validated.

    Raises:
        DiagnosticsError: No remaining part can be checked.
    """
    return _Salvage(source, model, diagnostics).salvage(errors)


class _Salvage(Generic[D]):
    def __init__(
        self, source: SourceMap, model: type[D], diagnostics: Iterable[Diagnostic]
    ) -> None:
        self._source = source
        self._model = model
        self._faults = list(diagnostics)
        self._broken = Broken()
        self._respelt: set[Steps] = set()
        self._unknown: dict[str, object] = {}
        relative = model.is_for_any_robot(source.root.plain())
        self._context = {"folder": source.path.parent, "relative": relative}

    def salvage(self, errors: Sequence[ErrorDetails]) -> Loaded[D]:
        judged = self._judge_words() if self._faults else errors
        faulty = list(_faulty(self._source.root, ()))
        self._leave_out(faulty)
        errors = () if faulty else judged
        if errors:
            self._mend(errors)
        for _ in range(_MOST_ROUNDS - bool(errors)):
            try:
                document = self._validated()
            except ValidationError as error:
                self._mend(error.errors(include_url=False))
            else:
                # Placeholders satisfied the validation; from here on, checks must recognize them as
                # unknown.
                document = document.model_copy(update=self._unknown)
                source = self._source._replace(broken=self._broken)
                return Loaded(document, source, tuple(self._faults))
        raise DiagnosticsError(self._faults)

    def _validated(self) -> D:
        return self._model.model_validate(self._source.root.plain(), context=self._context)

    def _judge_words(self) -> list[ErrorDetails]:
        """Treat words such as ``off`` as texts if no text is allowed, for a better diagnostic.

        Quoting a word is a remedy only if a text is allowed.

        Returns:
            Errors of the document, if there are such words.
        """
        words = {diagnostic.place for diagnostic in self._faults if diagnostic.code == _WORD}
        if not words:
            return []
        errors = self._errors()
        wrong = {path_of(error, self._source) for error in errors}
        places = set()
        for path in _faulty(self._source.root, ()):
            node = self._source.node(path)
            if path in wrong and node.place in words:
                node.faulty = False
                places.add(node.place)
        self._faults = [f for f in self._faults if f.code != _WORD or f.place not in places]
        return errors

    def _errors(self) -> list[ErrorDetails]:
        try:
            self._validated()
        except ValidationError as error:
            return error.errors(include_url=False)
        return []

    def _mend(self, errors: Sequence[ErrorDetails]) -> None:
        """Report the faults, and remove the faulty parts."""
        # A misspelt key may replace a missing one, as `steps` replaces `actions`.
        keys = [str(each["loc"][-1]) for each in errors if each["type"] == "extra_forbidden"]
        others = self._model.alternatives.items()
        replaced = {(key,) for key, by in others if any(nearest_name(each, keys) for each in by)}
        errors = [e for e in errors if e["type"] != "missing" or e["loc"] not in replaced]
        located = [(path_of(error, self._source), error) for error in errors]
        if moves := find_moves(self._source, self._model, [path for path, _ in located]):
            # Other faults are found in the next round, with these keys in their places.
            self._faults += [move(self._source, moved) for moved in moves]
            return
        self._faults += diagnostics_of(errors, self._source, self._model, self._follows)
        # A value with a fault inside may be valid once the inner fault is removed.
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
        """Return whether a fault only follows from another."""
        if kind == "extra_forbidden":
            return False
        others = self._model.alternatives.get(str(path[0]), ()) if len(path) == 1 else ()
        is_replaced = any(self._broken.touches((other,)) for other in others)
        return is_replaced or path in self._respelt or self._broken.is_below(path)

    def _respell(self, path: Steps, loc: Steps) -> bool:
        """Move a value to the key that was probably intended, and return whether one exists."""
        parent, key = self._source.node(path[:-1]), str(path[-1])
        if not isinstance(parent.value, dict) or key not in parent.value:
            return False
        shape = SchemaShape((self._model,)).located(loc[:-1])
        free = sorted(shape.keys.keys() - parent.value)
        new = shape.renamed.get(key)
        suggestion = nearest_name(key, free) if new is None else new if new in free else None
        if suggestion is not None:
            parent.value[suggestion] = parent.value.pop(key)
            parent.keys[suggestion] = parent.keys.pop(key)
            self._respelt.add((*path[:-1], suggestion))
        return suggestion is not None

    def _leave_out(self, paths: Iterable[Steps]) -> None:
        """Remove the parts at the given paths, and the parts incomplete without them."""
        parts = {_part(path, self._model) for path in paths}
        # The last items of a list are removed first, so that the indices of the others stay valid.
        # Indices are padded, because 10 would otherwise sort before 9.
        for part in sorted(parts, key=lambda part: [str(step).zfill(9) for step in part])[::-1]:
            if not part:
                raise DiagnosticsError(self._faults)
            self._drop(part)
        for part in parts:
            self._complete(part)

    def _drop(self, part: Steps) -> None:
        self._source.node(part[:-1]).drop(part[-1])
        # In `track {gain: 3}`, `{arm right_arm}` or `models:{pan: head}` the key comes first.
        self._broken.add([part, (*part[:-1], re.split("[ :{]", str(part[-1]))[0])])

    def _complete(self, part: Steps) -> None:
        """Remove the parts around a removed one that require it; replace a key of the document."""
        while self._source.holds(*part[:-1]) and self._is_required(part):
            if len(part) > 1:
                part = part[:-1]
                self._drop(part)
                continue
            if str(part[0]) in self._stand_ins:
                self._stand_in(str(part[0]))
            return

    def _is_required(self, part: Steps) -> bool:
        """Return whether a section requires a removed key, or a list or mapping one more entry."""
        model: type[BaseModel] = self._model
        for depth, step in enumerate(part[:-1], 2):
            field = model.model_fields.get(str(step))
            if field is None:
                return False
            inner = field.annotation
            if isinstance(inner, type) and issubclass(inner, BaseModel):
                model = inner
                continue
            least = max((getattr(limit, "min_length", 0) for limit in field.metadata), default=0)
            left = len(list(self._source.node(part[:-1]).steps()))
            return depth == len(part) and left < least
        if len(part) == 1 and part[0] in self._model.alternatives:
            return not any(map(self._source.holds, self._model.alternatives[str(part[0])]))
        last = model.model_fields.get(str(part[-1]))
        return last is not None and last.is_required()

    @property
    def _stand_ins(self) -> Mapping[str, object]:
        """Placeholders for required values, which checks ignore."""
        return {"name": "unknown", **kind_of(self._model).stand_ins}

    def _stand_in(self, key: str) -> None:
        root, stand_ins = self._source.root, self._stand_ins
        if key not in stand_ins or not isinstance(root.value, dict):
            raise DiagnosticsError(self._faults)
        root.value[key] = _node(stand_ins[key], root.place)
        self._broken.add([(key,)])
        if stand_ins[key] == "unknown":
            self._unknown[key] = UNKNOWN
        elif stand_ins[key] == ["unknown"]:
            self._unknown[key] = ()


def _faulty(node: Node, path: Steps) -> Iterator[Steps]:
    """Yield the paths of the nodes that are marked as faulty."""
    if node.faulty:
        yield path
    for step, child in node.steps():
        yield from _faulty(child, (*path, step))


def _part(path: Steps, model: type[BaseModel]) -> Steps:
    """Return the path of the outermost list item or named entry along a path, or the whole path.

    The rest of an entry is meaningless without its faulty part.
    """
    for depth, step in enumerate(path):
        field = model.model_fields.get(str(step))
        if field is None:
            return path[: depth + 1]
        inner = field.annotation
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            # The field is a list or a mapping of names, so the next step is one of its entries.
            return path[: depth + 2]
        model = inner
    return path


def _node(value: Any, place: Place) -> Node:
    """Return a value as a node at a place."""
    if isinstance(value, dict):
        return Node(place, {key: _node(inner, place) for key, inner in value.items()})
    if isinstance(value, list):
        return Node(place, [_node(inner, place) for inner in value])
    return Node(place, value)
