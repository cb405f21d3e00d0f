"""Shared controllers in a program: each call becomes a controller of its own, by its text."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, Protocol

from pydantic import ValidationError

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.documents.program import ControllerSection, ProgramDocument
from cbdsl.documents.shared import SharedDocument
from cbdsl.language.exit import parse_when
from cbdsl.language.expression import SUBJECT_TO, Term
from cbdsl.language.parameters import filled, parameters_in
from cbdsl.language.parser import parse
from cbdsl.language.scanner import CompositionError
from cbdsl.yaml_text.broken import Broken
from cbdsl.yaml_text.composer import Composed
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.reader import read_composed

Steps = tuple[str | int, ...]


class SharedDocuments(Protocol):
    """Methods of a library that find shared documents; see ``Library``."""

    def find(self, kind: type[SharedDocument], name: str, beside: Path | None) -> Path | None: ...

    def names(self, kind: type[SharedDocument], beside: Path | None) -> list[str]: ...

    def shared_parts(self, path: Path) -> Mapping[str, SharedPart]: ...


class SharedPart(NamedTuple):
    """Controller, composition or condition of a shared document.

    Attributes:
        section: Section that holds it.
        signature: Name with its parameters, as written.
        node: Declaration.
        siblings: All parts of the document, by name.
    """

    section: str
    signature: Term
    node: Node
    siblings: Mapping[str, SharedPart]

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of its parameters, in order."""
        return tuple(each.text for each in self.signature.arguments)

    def filled(self, call: Term, place: Place | None = None) -> Node:
        """Return the declaration with the arguments of a call.

        Args:
            call: Call, with one argument for each parameter.
            place: Place that all of it counts as written at; its own by default.
        """
        arguments = (each.text for each in call.arguments)
        return _filled(self.node, dict(zip(self.parameters, arguments, strict=True)), place)


def shared_parts(loaded: Loaded[SharedDocument], faults: Diagnostics) -> dict[str, SharedPart]:
    """Return the parts of a shared document by name; report parts that no program can call."""
    parts: dict[str, SharedPart] = {}
    for section in ("controllers", "conditions"):
        entries = loaded.source.node((section,)).steps() if loaded.source.holds(section) else ()
        for key, node in entries:
            signature = parse(str(key)).terms[0]
            if signature.name in parts:
                related = [(loaded.source.key(*_path(parts[signature.name])), "the first one")]
                details = {"name": signature.name, "related": related, "other": "part"}
                faults.add("CB703", loaded.source.key(section, key), **details)
            parts[signature.name] = SharedPart(section, signature, node, parts)
    for part in parts.values():
        _check_parameters(part, loaded, faults)
        _check_calls(part, (part.signature.name,), loaded, faults)
    return parts


def _path(part: SharedPart) -> Steps:
    return part.section, str(part.signature)


def _check_parameters(
    part: SharedPart, loaded: Loaded[SharedDocument], faults: Diagnostics
) -> None:
    source, used = loaded.source, set[str]()
    for path, node in _texts(part.node, _path(part)):
        for match in parameters_in(str(node.value)):
            used.add(match[1])
            if match[1] not in part.parameters:
                place = source.inside(path, match.start() + 1, match.end() + 1)
                hint = f"; write it in the signature of '{part.signature.name}'"
                faults.add("CB402", place, names=part.parameters, name=match[1], hint=hint)
    for name in part.parameters:
        if name not in loaded.document.parameters:
            hint = "; give it a value to check with in 'parameters'"
            names = list(loaded.document.parameters)
            faults.add("CB402", source.key(*_path(part)), names=names, name=name, hint=hint)
        elif name not in used and used <= set(part.parameters):
            faults.add("CB702", source.key(*_path(part)), name=name)


def _check_calls(
    part: SharedPart, chain: tuple[str, ...], loaded: Loaded[SharedDocument], faults: Diagnostics
) -> None:
    """Check the calls of a composition, and that none leads back to one of a chain of callers."""
    if not isinstance(part.node.value, str) or part.section != "controllers":
        return
    source, path = loaded.source, _path(part)
    try:
        terms = parse(part.node.value).terms
    except CompositionError as error:
        place = source.inside(path, error.span.start, error.span.end)
        faults.add("CB401", place, problem=str(error))
        return
    for term in terms:
        place, called = source.inside(path, *term.span), part.siblings.get(term.name)
        if called is None or called.section != "controllers":
            names = [name for name, each in part.siblings.items() if each.section == part.section]
            faults.add("CB404", place, names=names, name=term.name)
        elif not agrees(term, called.parameters, place, faults):
            continue
        elif term.name == chain[0]:
            if term.name != min(chain):  # reported there
                continue
            cycle = " → ".join((*chain, term.name))
            faults.add("CB405", source.key(*path), name=chain[0], cycle=cycle)
        elif term.name not in chain:
            _check_calls(called, (*chain, term.name), loaded, faults)


def agrees(call: Term, wanted: tuple[str, ...], place: Place, faults: Diagnostics) -> bool:
    """Return whether a call has one argument for each parameter; report it otherwise."""
    given = len(call.arguments)
    if given == len(wanted):
        return True
    names = f" ({', '.join(wanted)})" if wanted else ""
    details = {
        "name": call.name,
        "wanted": count(len(wanted), "argument") + names,
        "found": f"{given or 'none'} {'is' if given <= 1 else 'are'}",
    }
    faults.add("CB403", place, **details)
    return False


def _texts(node: Node, path: Steps = ()) -> Iterator[tuple[Steps, Node]]:
    """Yield the texts of a declaration with their paths."""
    if isinstance(node.value, str):
        yield path, node
    for step, child in node.steps():
        yield from _texts(child, (*path, step))


def _filled(node: Node, values: Mapping[str, str], place: Place | None) -> Node:
    value = node.value
    copy = Node(place or node.place, filled(value, values) if isinstance(value, str) else value)
    if isinstance(value, dict):
        copy.value = {key: _filled(child, values, place) for key, child in value.items()}
        copy.keys = {key: place or own for key, own in node.keys.items()}
    elif isinstance(value, list):
        copy.value = [_filled(child, values, place) for child in value]
    copy.weight, copy.height, copy.written = node.weight, node.height, node.written
    return copy


def as_program(
    loaded: Loaded[SharedDocument], parts: Mapping[str, SharedPart], text: str
) -> Loaded[ProgramDocument]:
    """Return a program of all parts, each by its name, with the places of the shared document.

    Args:
        loaded: Shared document.
        parts: Parts without faults.
        text: Text of its file.
    """
    # Quantities and names of controllers stand in places that no parameter of a program can have.
    texts = (each for part in parts.values() for each in _texts(part.node))
    awaited = {node.value for path, node in texts if path[-1:] in (("requires",), ("once",))}
    values = {
        name: value if f"${name}" in awaited or value[:1] in "+-.0123456789" else f"${name}"
        for name, value in loaded.document.parameters.items()
    }
    examples = {
        name: part.signature._replace(
            arguments=tuple(
                each._replace(text=values[each.text]) for each in part.signature.arguments
            )
        )
        for name, part in parts.items()
    }
    nodes: dict[str, dict[str, Node]] = {"controllers": {}, "conditions": {}}
    own: list[tuple[str, Term, Place | None]] = [(name, examples[name], None) for name in parts]
    for name, call, place in own:  # the list grows
        part = parts[call.name]
        if name in nodes[part.section]:
            continue
        node = nodes[part.section][name] = part.filled(call, place)
        if part.section == "controllers" and isinstance(node.value, str):
            # A part that is called with its own values is checked by its name alone.
            terms = {
                term.name if str(term) == str(examples[term.name]) else str(term): term
                for term in parse(node.value).terms
            }
            own += [(each, term, node.place) for each, term in terms.items()]
            node.value = SUBJECT_TO.join(terms)
    return _program_of(nodes, loaded, text)


def _program_of(
    nodes: Mapping[str, Mapping[str, Node]], loaded: Loaded[SharedDocument], text: str
) -> Loaded[ProgramDocument]:
    source, place = loaded.source, loaded.source.root.place
    fields = {key: source.node((key,)) for key in ("cbdsl", "name", "robot")}
    fields["kind"] = Node(place, "program")
    fields["actions"] = Node(place, [Node(place, name) for name in nodes["controllers"]] or [])
    for section, entries in nodes.items():
        fields[section] = Node(place, dict(entries))
        fields[section].keys = {name: node.place for name, node in entries.items()}
    if source.holds("parameters"):
        fields["parameters"] = source.node(("parameters",))
    composed = Composed(Node(place, fields), (), source.lines)
    program = read_composed(source.path, ProgramDocument, text, composed)
    return program._replace(taken=frozenset(nodes["controllers"]))


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
    return "(" in text and any(str(term) in calls for term in _terms(text))


def _is_call_of(name: str, declared: object) -> bool:
    """Return whether a declaration is one call alone, as `watch: watch(red)`."""
    return isinstance(declared, str) and [t.name for t in _terms(declared)] == [name]


def _terms(text: str) -> tuple[Term, ...]:
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
                terms = _terms(text)
                for term in terms:
                    yield (section, name), term, len(terms) == 1
    for path, text in _compositions(document):
        for term in _terms(text):
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
