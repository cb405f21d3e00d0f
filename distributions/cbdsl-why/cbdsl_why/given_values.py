"""Values that documents give to shared controllers, to used programs, and to their own parameters.

Such a value stands for that of a key, e.g. for the gain of a shared controller, or for the force
of a grasp of a used program. A parameter that is also written elsewhere, such as in a goal, a
tolerance or a condition, stands for nothing that a patch may change.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.extend.document import (
    ProgramDocument,
    SharedDocument,
    SourceMap,
    compose,
    lines_of,
    parameters_in,
    terms_of,
)

if TYPE_CHECKING:
    from cbdsl.extend.document import Library, Node, Place, SharedPart
    from cbdsl_why.structural_patches import Keys

# Sections of a program whose texts are compositions, and the key of those of its steps.
_COMPOSITIONS, _DO = ("controllers", "background", "actions"), "do"


class ParameterScope(NamedTuple):
    """Text in which a parameter has one meaning.

    Attributes:
        file: File of the document.
        part: Name of a shared controller; empty for a program.
    """

    file: Path
    part: str = ""


class GivenValue(NamedTuple):
    """Value that a text gives to a parameter.

    Attributes:
        path: Path of keys of the text in its document, with the parameter of a call.
        text: The text, with the value and the rest of its call.
        place: Place of the value.
        value: The value.
        scope: Program or shared controller that declares the parameter.
        parameter: Name of the parameter.
    """

    path: Keys
    text: Node
    place: Place
    value: str
    scope: ParameterScope
    parameter: str


class GivenValues:
    """Values that the documents of a run give to parameters, and the keys that these stand for.

    Args:
        library: Documents of the run.
        keys: Keys that may be stood for.
    """

    def __init__(self, library: Library, keys: Collection[str]) -> None:
        self._library, self._keys = library, keys
        self._meanings = dict[tuple[ParameterScope, str], str]()
        self._sources = dict[Path, SourceMap]()

    def source(self, file: Path) -> SourceMap:
        """Return the values of a document as they are written, with their places."""
        if file not in self._sources:
            text = self._library.text(file)
            self._sources[file] = SourceMap(file, lines_of(text), compose(text, str(file)).root)
        return self._sources[file]

    def meaning(self, scope: ParameterScope, parameter: str) -> str:
        """Return the key that a parameter stands for; empty for none, or for anything else."""
        place = scope, parameter
        if place not in self._meanings:
            self._meanings[place] = ""  # of a program that uses itself
            keys = set(self._each_meaning(scope, parameter))
            self._meanings[place] = keys.pop() if len(keys) == 1 else ""
        return self._meanings[place]

    def _each_meaning(self, scope: ParameterScope, parameter: str) -> Iterator[str]:
        written, node = f"${parameter}", self.node(scope)
        passed = [each for each in self.given(scope) if parameter in _parameters(each.value)]
        for each in passed:
            yield self.meaning(each.scope, each.parameter) if each.value == written else ""
        for keys, text in node.texts():
            times = _parameters(str(text.value)).count(parameter)
            times -= sum(each.text is text for each in passed)
            if times:
                key = str(keys[-1]) if keys else ""
                is_value = key in self._keys and _is_value(key, str(text.value), written)
                yield key if is_value else ""
        yield from ("" for key in _mapping_keys(node) if parameter in _parameters(key))

    def node(self, scope: ParameterScope) -> Node:
        """Return the declaration of a shared controller, or all of a program."""
        return self._part(scope).node if scope.part else self.source(scope.file).root

    def keys(self, scope: ParameterScope) -> Keys:
        """Return the path of keys of a shared controller in its document; none for a program."""
        return ("controllers", str(self._part(scope).signature)) if scope.part else ()

    def _part(self, scope: ParameterScope) -> SharedPart:
        return self._library.shared_parts(scope.file)[scope.part]

    def _document(self, scope: ParameterScope) -> ProgramDocument:
        return self._library.read_as_written(scope.file, ProgramDocument).document

    def given(self, scope: ParameterScope) -> Iterator[GivenValue]:
        """Yield the values that a program, or a shared controller, gives to others."""
        for keys, text in self.node(scope).texts():
            if scope.part or keys[0] in _COMPOSITIONS or keys[-1] == _DO:
                yield from self._arguments(scope, (*self.keys(scope), *keys), text)
        for name, use in () if scope.part else self._document(scope).use.items():
            file = self._library.find(ProgramDocument, use.program, scope.file)
            if file is not None:
                for parameter in use.with_:
                    path = ("use", name, "with", parameter)
                    yield self._whole(scope, path, ParameterScope(file))

    def defaults(self, scope: ParameterScope) -> Iterator[GivenValue]:
        """Yield the values that a program gives to its own parameters."""
        for name in () if scope.part else self._document(scope).parameters:
            yield self._whole(scope, ("parameters", name), scope)

    def _whole(self, scope: ParameterScope, path: Keys, called: ParameterScope) -> GivenValue:
        node = self.source(scope.file).node(path)
        return GivenValue(path, node, node.place, str(node.value), called, str(path[-1]))

    def _arguments(self, scope: ParameterScope, path: Keys, text: Node) -> Iterator[GivenValue]:
        callable_, source = self._callable(scope), self.source(scope.file)
        for term in terms_of(str(text.value)):
            called = callable_.get(term.name)
            names = self._part(called).parameters if called is not None else ()
            if called is not None and len(names) == len(term.arguments):
                for name, argument in zip(names, term.arguments, strict=True):
                    place = source.inside(path, *argument.span)
                    yield GivenValue((*path, name), text, place, argument.text, called, name)

    def _callable(self, scope: ParameterScope) -> Mapping[str, ParameterScope]:
        """Return the shared controllers that a program, or a shared controller, may call."""
        if scope.part:
            return {
                name: ParameterScope(scope.file, name) for name in self._controllers(scope.file)
            }
        called = dict[str, ParameterScope]()
        for document, names in self._document(scope).shared.items():
            file = self._library.find(SharedDocument, document, scope.file)
            if file is not None:
                known = self._controllers(file)
                called |= {name: ParameterScope(file, name) for name in names if name in known}
        return called

    def _controllers(self, file: Path) -> Collection[str]:
        parts = self._library.shared_parts(file)
        return [name for name, part in parts.items() if part.section == "controllers"]

    def all_called(self, scopes: Sequence[ParameterScope]) -> list[ParameterScope]:
        """Return the shared controllers that programs call, directly or by one another."""
        reached = list(scopes)
        for scope in reached:  # the list grows
            callable_ = self._callable(scope)
            texts = (str(text.value) for _, text in self.node(scope).texts())
            called = [callable_.get(term.name) for text in texts for term in terms_of(text)]
            reached += [each for each in dict.fromkeys(called) if each and each not in reached]
        return reached[len(scopes) :]


def _is_value(key: str, text: str, written: str) -> bool:
    """Return whether a text is a parameter alone; of references, a force along normals.

    Such a force is no goal, unlike a place or a bound.
    """
    return text.startswith(f"{written} along ") if key == "reference" else text == written


def _parameters(text: str) -> list[str]:
    return [match[1] for match in parameters_in(text)]


def _mapping_keys(node: Node) -> Iterator[str]:
    for step, child in node.steps():
        yield str(step)
        yield from _mapping_keys(child)
