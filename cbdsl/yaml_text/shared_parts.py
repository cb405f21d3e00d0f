"""Parts of shared documents: controllers, compositions and conditions with parameters."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import NamedTuple

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.shared import SharedDocument
from cbdsl.language.expression import SUBJECT_TO, Term
from cbdsl.language.parameters import filled, parameters_in
from cbdsl.language.parser import parse
from cbdsl.language.scanner import CompositionError
from cbdsl.yaml_text.composer import Composed
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.reader import read_composed

Steps = tuple[str | int, ...]


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
    """Return the parts of a shared document by name; report and omit values that are faulty."""
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
        for key in loaded.source.broken.keys((section,)):
            with suppress(CompositionError):
                signature = parse(key).terms[0]
                omitted = _omitted(loaded.source.root.place)
                parts.setdefault(signature.name, SharedPart(section, signature, omitted, parts))
    for part in [part for part in parts.values() if not _is_sound(part, loaded, faults)]:
        parts[part.signature.name] = part._replace(node=_omitted(part.node.place))
    return parts


def _omitted(place: Place) -> Node:
    node = Node(place, None)
    node.faulty = True
    return node


def unused_parameters(
    loaded: Loaded[SharedDocument], parts: Mapping[str, SharedPart]
) -> Diagnostics:
    """Return findings for the parameters of a document, and of its parts, that nothing uses."""
    unused, source = Diagnostics(), loaded.source
    named = {name for part in parts.values() for name in part.parameters}
    for name in loaded.document.parameters:
        if name not in named:
            unused.add("CB702", source.key("parameters", name), name=name)
    for part in parts.values():
        used = {
            match[1] for _, node in part.node.texts() for match in parameters_in(str(node.value))
        }
        for name in part.parameters:
            if name not in used:
                unused.add("CB702", source.key(*_path(part)), name=name)
    return unused


def _is_sound(part: SharedPart, loaded: Loaded[SharedDocument], faults: Diagnostics) -> bool:
    """Report the faults of a part; return whether it can be checked."""
    before, values = faults.added, loaded.document.parameters
    _check_parameters(part, loaded, faults)
    _check_calls(part, (part.signature.name,), loaded, faults)
    return faults.added == before and values.keys() >= set(part.parameters)


def _path(part: SharedPart) -> Steps:
    return part.section, str(part.signature)


def _check_parameters(
    part: SharedPart, loaded: Loaded[SharedDocument], faults: Diagnostics
) -> None:
    source = loaded.source
    for path, node in part.node.texts(_path(part)):
        for match in parameters_in(str(node.value)):
            if match[1] not in part.parameters:
                place = source.inside(path, match.start() + 1, match.end() + 1)
                hint = f"; write it in the signature of '{part.signature.name}'"
                faults.add("CB402", place, names=part.parameters, name=match[1], hint=hint)
    declared = source.declared(loaded.document.parameters, "parameters")
    for name in part.parameters:
        if name not in declared and not source.broken.holds("parameters"):
            hint = "; give it a value to check with in 'parameters'"
            names = list(loaded.document.parameters)
            faults.add("CB402", source.key(*_path(part)), names=names, name=name, hint=hint)


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


def _filled(node: Node, values: Mapping[str, str], place: Place | None) -> Node:
    value = node.value
    copy = Node(place or node.place, filled(value, values) if isinstance(value, str) else value)
    if isinstance(value, dict):
        copy.value = {key: _filled(child, values, place) for key, child in value.items()}
        copy.keys = {key: place or own for key, own in node.keys.items()}
    elif isinstance(value, list):
        copy.value = [_filled(child, values, place) for child in value]
    copy.weight, copy.height, copy.written = node.weight, node.height, node.written
    copy.faulty = node.faulty
    return copy


def as_program(
    loaded: Loaded[SharedDocument],
    parts: Mapping[str, SharedPart],
    text: str,
    diagnostics: tuple[Diagnostic, ...],
) -> Loaded[ProgramDocument]:
    """Return a program of all parts, each by its name, with the places of the shared document.

    Args:
        loaded: Shared document.
        parts: Parts of the document.
        text: Text of its file.
        diagnostics: Diagnostics so far.
    """
    # Quantities and names of controllers stand in places that no parameter of a program can have.
    texts = (each for part in parts.values() for each in part.node.texts())
    awaited = {node.value for path, node in texts if path[-1:] in (("requires",), ("once",))}
    values = {
        name: value if f"${name}" in awaited or value[:1] in "+-.0123456789" else f"${name}"
        for name, value in loaded.document.parameters.items()
    }
    examples = {
        name: part.signature._replace(
            arguments=tuple(
                each._replace(text=values.get(each.text, each.text))
                for each in part.signature.arguments
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
    return _program_of(nodes, loaded, text, diagnostics)


def _program_of(
    nodes: Mapping[str, Mapping[str, Node]],
    loaded: Loaded[SharedDocument],
    text: str,
    diagnostics: tuple[Diagnostic, ...],
) -> Loaded[ProgramDocument]:
    source, place = loaded.source, loaded.source.root.place
    fields = {key: source.node((key,)) for key in ("cbdsl", "name", "robot")}
    fields["kind"] = Node(place, "program")
    actions: list[Node] = [Node(place, name) for name in nodes["controllers"]]
    fields["actions"] = Node(place, actions) if actions else _omitted(place)
    for section, entries in nodes.items():
        fields[section] = Node(place, dict(entries))
        fields[section].keys = {name: node.place for name, node in entries.items()}
    if source.holds("parameters"):
        fields["parameters"] = source.node(("parameters",))
    composed = Composed(Node(place, fields), diagnostics, source.lines)
    program = read_composed(source.path, ProgramDocument, text, composed)
    return program._replace(taken=frozenset(nodes["controllers"]))
