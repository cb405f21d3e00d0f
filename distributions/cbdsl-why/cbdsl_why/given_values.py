"""Values that documents give to shared controllers, to used programs, and to their own parameters.

Such a value stands for that of a key, e.g. for the gain of a shared controller, or for the force
of a grasp of a used program. A parameter that is also written elsewhere, such as in a goal, a
tolerance or a condition, stands for nothing that a patch may change.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from cbdsl.extend.document import (
    Library,
    Node,
    ProgramDocument,
    SharedDocument,
    compose,
    parameters_in,
    terms_of,
)
from cbdsl_why.structural_patches import Keys

# Sections of a program whose texts are compositions, and the key of those of its steps.
_COMPOSITIONS, _DO = ("controllers", "background", "actions"), "do"


class ParameterScope(NamedTuple):
    """Text in which a parameter has one meaning.

    Attributes:
        file: File of the document.
        signature: Signature of a shared controller; empty for a program.
    """

    file: Path
    signature: str = ""

    @property
    def keys(self) -> Keys:
        """Path of keys of the text in its document."""
        return ("controllers", self.signature) if self.signature else ()


class GivenValue(NamedTuple):
    """Value that a text gives to a parameter.

    Attributes:
        path: Path of keys of the text in its document, and the parameter of a call.
        node: The text.
        start: Index of the first character of the value in it.
        value: The value.
        scope: Program or shared controller that declares the parameter.
        parameter: Name of the parameter.
    """

    path: Keys
    node: Node
    start: int
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
        self.root = cache(self._read)

    def _read(self, file: Path) -> Node:
        return compose(self._library.text(file), str(file)).root

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
        for keys, text in _texts(node):
            times = _parameters(str(text.value)).count(parameter)
            times -= sum(each.node is text for each in passed)
            if times:
                key = str(keys[-1]) if keys else ""
                is_value = key in self._keys and _is_value(key, str(text.value), written)
                yield key if is_value else ""
        yield from ("" for key in _mapping_keys(node) if parameter in _parameters(key))

    def node(self, scope: ParameterScope) -> Node:
        """Return the declaration of a shared controller, or all of a program."""
        return _at(self.root(scope.file), *scope.keys)

    def parameters(self, scope: ParameterScope) -> Iterator[tuple[str, Node]]:
        """Yield the parameters of a program with their values; a call gives those of another."""
        if not scope.signature:
            for name, node in _at(self.root(scope.file), "parameters").steps():
                if node.place.end_column:
                    yield str(name), node

    def given(self, scope: ParameterScope) -> Iterator[GivenValue]:
        """Yield the values that a program, or a shared controller, gives to parameters."""
        for keys, node in _texts(self.node(scope)):
            if scope.signature or keys[0] in _COMPOSITIONS or keys[-1] == _DO:
                yield from self._arguments(scope, keys, node)
            elif keys[0] == "use" and keys[2:3] == ("with",) and len(keys) == 4:
                name = _at(self.root(scope.file), *keys[:2], "program").value
                file = self._library.find(ProgramDocument, str(name), scope.file)
                if file is not None:
                    yield GivenValue(
                        keys, node, 0, str(node.value), ParameterScope(file), str(keys[-1])
                    )

    def _arguments(self, scope: ParameterScope, keys: Keys, node: Node) -> Iterator[GivenValue]:
        called = self.callable(scope)
        for term in terms_of(str(node.value)):
            callee = called.get(term.name)
            names = _signature(callee.signature) if callee is not None else ()
            if callee is not None and len(names) == len(term.arguments):
                for name, argument in zip(names, term.arguments, strict=True):
                    path = (*scope.keys, *keys, name)
                    start = argument.span.start - 1
                    yield GivenValue(path, node, start, argument.text, callee, name)

    def callable(self, scope: ParameterScope) -> Mapping[str, ParameterScope]:
        """Return the shared controllers that a program, or a shared controller, may call."""
        if scope.signature:
            return self._shared(scope.file)
        called = dict[str, ParameterScope]()
        for document, names in _at(self.root(scope.file), "shared").steps():
            file = self._library.find(SharedDocument, str(document), scope.file)
            parts = self._shared(file) if file is not None else {}
            taken = [str(each.value) for each in names.children()]
            called |= {name: parts[name] for name in taken if name in parts}
        return called

    def all_called(self, scopes: Sequence[ParameterScope]) -> list[ParameterScope]:
        """Return the shared controllers that programs call, directly or by one another."""
        reached = list(scopes)
        for scope in reached:  # the list grows
            callable_ = self.callable(scope)
            texts = (str(node.value) for _, node in _texts(self.node(scope)))
            called = [callable_.get(term.name) for text in texts for term in terms_of(text)]
            reached += [each for each in dict.fromkeys(called) if each and each not in reached]
        return reached[len(scopes) :]

    def _shared(self, file: Path) -> Mapping[str, ParameterScope]:
        """Return the controllers of a shared document by name."""
        signatures = [str(key) for key, _ in _at(self.root(file), "controllers").steps()]
        return {
            terms_of(each)[0].name: ParameterScope(file, each)
            for each in signatures
            if terms_of(each)
        }


def _is_value(key: str, text: str, written: str) -> bool:
    """Return whether a text is a parameter alone; of references, a force along normals.

    Such a force is no goal, unlike a place or a bound.
    """
    return text.startswith(f"{written} along ") if key == "reference" else text == written


def _parameters(text: str) -> list[str]:
    return [match[1] for match in parameters_in(text)]


def _signature(text: str) -> tuple[str, ...]:
    """Return the names of the parameters of a signature, in order."""
    return tuple(each.text for term in terms_of(text) for each in term.arguments)


def _texts(node: Node, keys: Keys = ()) -> Iterator[tuple[Keys, Node]]:
    """Yield the texts below a node with their paths of keys."""
    if isinstance(node.value, str):
        yield keys, node
    for step, child in node.steps():
        yield from _texts(child, (*keys, step))


def _mapping_keys(node: Node) -> Iterator[str]:
    for step, child in node.steps():
        yield str(step)
        yield from _mapping_keys(child)


def _at(node: Node, *keys: str | int) -> Node:
    """Return the value at a path of keys; nothing if there is none."""
    for key in keys:
        node = dict(node.steps()).get(key) or Node(node.place, None)
    return node
