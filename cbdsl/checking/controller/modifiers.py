"""Modifiers of a controller: known kinds that fit its feedback."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents import program as written
from cbdsl.program.controller import Modifier
from cbdsl.types.modifier import MODIFIERS, ModifierType
from cbdsl.types.resource import Resource
from cbdsl.types.unit import QuantityError, read_quantity


def read_modifiers(
    context: ProgramContext, steps: Steps, document: written.ControllerSection, feedback: Resource
) -> tuple[Modifier, ...]:
    """Return the valid modifiers of a controller, and report the invalid ones."""
    modifiers = []
    for name, options in document.modifiers.items():
        own: Steps = (*steps, "modifiers", name)
        problem = _problem(name, options, document, feedback)
        if isinstance(problem, str):
            names = list(MODIFIERS.names())
            context.add("CB531", context.source.key(*own), names=names, name=name, problem=problem)
        else:
            modifiers.append(Modifier(name, tuple(problem.items())))
    return tuple(modifiers)


def _problem(
    name: str,
    options: Mapping[str, str | float],
    document: written.ControllerSection,
    feedback: Resource,
) -> str | dict[str, float]:
    """Return the options in SI units, or the error of a modifier as a clause."""
    if name not in MODIFIERS:
        return f"unknown modifier '{name}'"
    try:
        kind = MODIFIERS.get(name)
    except UsageError as error:
        return str(error)
    if MODIFIERS.is_builtin(name):
        return "it is a key of the controller itself"
    lacks_reference = bool(kind.implementation) and document.reference is None
    if lacks_reference or feedback.type.name not in kind.accepts:
        what = "it changes references" if kind.implementation else "it is for feedback"
        return f"{what} of type {' or '.join(sorted(kind.accepts))}"
    return _read_options(kind, options)


def _read_options(kind: ModifierType, options: Mapping[str, str | float]) -> str | dict[str, float]:
    if options.keys() != kind.options.keys():
        return f"its options are {', '.join(kind.options) or 'none'}"
    try:
        return {
            name: read_quantity(options[name], (dimension,) if dimension else ())
            for name, dimension in kind.options.items()
        }
    except QuantityError as error:
        return str(error)
