"""Calls of shared parts in a program: each becomes a part of its own, by its text."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from pydantic import ValidationError

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.documents.program import ControllerSection, ProgramDocument
from cbdsl.documents.shared import SharedDocument
from cbdsl.language.exit import parse_when
from cbdsl.language.expression import Term
from cbdsl.language.parser import parse
from cbdsl.language.scanner import CompositionError
from cbdsl.yaml_text.broken import Broken
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.shared_parts import SharedPart, agrees

Steps = tuple[str | int, ...]


class SharedDocuments(Protocol):
    """Methods of a library that find shared documents; see ``Library``."""

    def find(self, kind: type[SharedDocument], name: str, beside: Path | None) -> Path | None: ...

    def names(self, kind: type[SharedDocument], beside: Path | None) -> list[str]: ...

    def shared_parts(self, path: Path) -> Mapping[str, SharedPart]: ...


def with_shared(
    loaded: Loaded[ProgramDocument], library: SharedDocuments
) -> Loaded[ProgramDocument]:
    """Return a program with the shared parts that it calls among its own, by the call's text.

    A controller of its own that is one call alone, as `level: keep_orientation($arm)`, is that
    shared controller under its own name.

    Args:
        loaded: Program that takes up shared parts.
        library: Library that finds the shared documents.
    """
    return _TakingUp(loaded, library).taken_up()


class _TakingUp:
    def __init__(self, loaded: Loaded[ProgramDocument], library: SharedDocuments) -> None:
        self._loaded, self._library = loaded, library
        self._faults = Diagnostics()
        self._unknown: set[str] = set()
        self._broken: set[Steps] = set()
        self._nodes: dict[str, dict[str, Node]] = {"controllers": {}, "conditions": {}}

    def taken_up(self) -> Loaded[ProgramDocument]:
        document, source = self._loaded.document, self._loaded.source
        parts, called = self._parts(), set[str]()
        for path, call, is_alone in _calls(document):
            is_key = "exits" in path
            inside = source.inside_key if is_key else source.inside
            place = inside(path, *call.span)
            called.add(call.name)
            if not is_alone and self._is_own(str(call)):
                continue
            if call.name in self._unknown:
                self._leave_out(str(call), call)
            elif (part := parts.get(call.name)) is not None:
                name = str(path[-1]) if is_alone and path[0] == part.section else str(call)
                self._take_up(part, call, place, name)
        for name, place in self._listed():
            if name in parts and name not in called:
                self._faults.add("CB701", place, name=name)
        return self._merged()

    def _is_own(self, name: str) -> bool:
        # An entry with a fault is left out of its section, and still declares its name.
        document, source = self._loaded.document, self._loaded.source
        return any(
            name in source.declared(getattr(document, section), section)
            for section in ("controllers", "use", "conditions")
        )

    def _listed(self) -> Iterator[tuple[str, Place]]:
        for shared, names in self._loaded.document.shared.items():
            for i, name in enumerate(names):
                yield name, self._loaded.source.place("shared", shared, i)

    def _parts(self) -> dict[str, SharedPart]:
        """Return the parts that the program takes up, by name; the others are unknown."""
        document, source = self._loaded.document, self._loaded.source
        taken: dict[str, SharedPart] = {}
        for shared, names in document.shared.items():
            known = self._known(shared, source.key("shared", shared))
            for i, name in enumerate(names):
                place = source.place("shared", shared, i)
                if name in known:
                    taken[name] = known[name]
                    if self._is_own(name) and not _is_call_of(name, document.controllers.get(name)):
                        self._faults.add("CB703", place, name=name, other="declaration below")
                    continue
                self._unknown |= {name, nearest_name(name, known) or name}
                if known:
                    details = {"names": list(known), "name": name, "shared": shared}
                    self._faults.add("CB629", place, **details)
        return taken

    def _known(self, name: str, place: Place) -> Mapping[str, SharedPart]:
        file = self._library.find(SharedDocument, name, self._loaded.path)
        if file is None:
            names = self._library.names(SharedDocument, self._loaded.path)
            self._faults.add("CB628", place, names=names, name=name)
            return {}
        try:
            return self._library.shared_parts(file)
        except DiagnosticsError as error:
            self._faults.extend(error.diagnostics)
            return {}

    def _take_up(self, part: SharedPart, call: Term, place: Place, name: str) -> None:
        if name in self._nodes[part.section]:
            return
        if not agrees(call, part.parameters, place, self._faults):
            self._leave_out(name, call)
            return
        node = self._nodes[part.section][name] = part.filled(call, place)
        if part.section == "controllers" and isinstance(node.value, str):
            for term in parse(node.value).terms:
                self._take_up(part.siblings[term.name], term, place, str(term))

    def _leave_out(self, name: str, call: Term) -> None:
        """Count a call with a fault, its name and the declaration that it is as unknown."""
        for section in self._nodes:
            self._broken |= {(section, each) for each in (name, str(call), call.name)}

    def _merged(self) -> Loaded[ProgramDocument]:
        document, root = self._loaded.document, self._loaded.source.root
        assert isinstance(root.value, dict), "a document is a mapping"
        update: dict[str, object] = {}
        try:
            for section, nodes in self._nodes.items():
                values = {name: self._validated(node) for name, node in nodes.items()}
                own = getattr(document, section).items()
                sound = {name: each for name, each in own if (section, name) not in self._broken}
                update[section] = {**sound, **values}
        except ValidationError:
            return self._with_invalid_arguments()
        for section, nodes in self._nodes.items():
            below = root.value.setdefault(section, Node(root.place, {}))
            if isinstance(below.value, dict):
                below.value.update(nodes)
                below.keys.update({n: below.keys.get(n, each.place) for n, each in nodes.items()})
        broken = self._loaded.source.broken if self._loaded.diagnostics else Broken()
        broken.add(self._broken)
        return self._loaded._replace(
            document=document.model_copy(update=update),
            source=self._loaded.source._replace(broken=broken),
            taken=frozenset(
                name
                for section, nodes in self._nodes.items()
                for name in nodes
                if name not in getattr(document, section)
            ),
            shared_faults=self._faults.sorted(),
        )

    def _validated(self, node: Node) -> ControllerSection | str:
        return validated(node.plain(), relative=bool(self._loaded.document.roles))

    def _with_invalid_arguments(self) -> Loaded[ProgramDocument]:
        """Return the program without the calls whose arguments have no valid values."""
        for section, nodes in self._nodes.items():
            for name, node in list(nodes.items()):
                try:
                    self._validated(node)
                except ValidationError as error:
                    first = error.errors(include_url=False)[0]
                    problem = first.get("ctx", {}).get("error", first["msg"])
                    key = ".".join(str(each) for each in first["loc"])
                    details = {"name": name, "key": key, "problem": problem}
                    self._faults.add("CB630", node.place, **details)
                    self._broken.add((section, name))
                    del nodes[name]
        return self._merged()


def validated(value: object, *, relative: bool) -> ControllerSection | str:
    """Return the declaration of a call; in terms of a robot that it lacks if ``relative``.

    Raises:
        ValidationError: An argument has no valid value.
    """
    if isinstance(value, str):
        return value
    return ControllerSection.model_validate(value, context={"relative": relative})


def has_call(text: str, calls: Collection[str]) -> bool:
    """Return whether a text is a composition with one of these calls."""
    return "(" in text and any(str(term) in calls for term in terms_of(text))


def _is_call_of(name: str, declared: object) -> bool:
    """Return whether a declaration is one call alone, as `watch: watch(red)`."""
    return isinstance(declared, str) and [t.name for t in terms_of(declared)] == [name]


def terms_of(text: str) -> tuple[Term, ...]:
    """Return the terms of a composition; none if it has an error, which its check reports."""
    try:
        return parse(text).terms
    except CompositionError:
        return ()


def _calls(document: ProgramDocument) -> Iterator[tuple[Steps, Term, bool]]:
    """Yield the names of controllers and conditions in a program.

    Yields:
        Path of the text, name with its arguments, and true if it is the whole text.
    """
    for section in ("controllers", "conditions"):
        for name, text in getattr(document, section).items():
            if isinstance(text, str):
                terms = terms_of(text)
                for term in terms:
                    yield (section, name), term, len(terms) == 1
    for path, text in _compositions(document):
        for term in terms_of(text):
            yield path, term, False
    for path, when in _exits(document):
        with suppress(CompositionError):
            for part in (part for way in parse_when(when) for part in way):
                yield path, part.term, False


def _exits(document: ProgramDocument) -> Iterator[tuple[Steps, str]]:
    for name, step in document.steps.items():
        for i, entry in enumerate(step.exits):
            yield from ((("steps", name, "exits", i, when), when) for when in entry)


def _compositions(document: ProgramDocument) -> Iterator[tuple[Steps, str]]:
    if document.background is not None:
        yield ("background",), document.background
    yield from ((("actions", i), text) for i, text in enumerate(document.actions))
    for name, step in document.steps.items():
        yield (("steps", name), name) if step.do is None else (("steps", name, "do"), step.do)
