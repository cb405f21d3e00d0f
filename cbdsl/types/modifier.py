"""Modifiers: types of changes to a controller, built in or added by packages."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from cbdsl.types.registry import PluginError, Registry
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import TYPES

Call = Callable[[str | None, str], str | None]
"""Function that returns a controller's name from its name in a program and the option."""


class OptionFault(NamedTuple):
    """Fault of a modifier's options.

    Attributes:
        option: Name of the faulty option.
        code: Code of the diagnostic.
        details: Values that fill the placeholders of the diagnostic's message.
    """

    option: str
    code: str
    details: Mapping[str, str]


class ModifierType(NamedTuple):
    """Change of a controller: of its reference in every tick, or of its slot in the plan.

    A modifier of another package is listed below ``modifiers`` in a program. A built-in modifier is
    a key of the controller, and a field of the checked controller.

    Attributes:
        name: Name in programs.
        summary: Effect, as a phrase.
        accepts: Names of the supported types of feedback.
        options: Dimension of each option, from ``unit.UNITS``; empty for a plain number.
        implementation: ``module:function`` of (reference, feedback, time, options) -> reference:
            values of the rows, shape (m,), simulated time, s, and options by name, in SI; empty
            if it does not change references.
        slot: ``module:function`` of (form, options, setting) -> form, of ``plan.SlotForm`` and
            ``runtime.slot_setting.SlotSetting``, called when a controller gets its slot; empty
            if it does not change slots.
        sources: Supported classes of feedback sources; empty for any source.
        purpose: Description of the supported feedback, for messages.
        residual: True if it changes residuals; a potential that is a field has no residual.
        read: Function that converts the document's field to the checked controller's field.
        fault: Function that returns the fault of the document's options, or ``None``.
        read_by: Names of the potentials that read its options themselves, for any feedback.
        positive, not_negative: Names of the options that must be positive, or not negative.
    """

    name: str
    summary: str
    accepts: frozenset[str]
    options: Mapping[str, str] = {}
    implementation: str = ""
    slot: str = ""
    sources: tuple[type, ...] = ()
    purpose: str = ""
    residual: bool = False
    read: Callable[[Any, Call], Any] = lambda section, _: section
    fault: Callable[[Any], OptionFault | None] = lambda _: None
    read_by: frozenset[str] = frozenset()
    positive: tuple[str, ...] = ()
    not_negative: tuple[str, ...] = ()

    def suits(self, feedback: Resource, potential: str) -> bool:
        """Return whether the modifier supports a feedback under a potential."""
        if potential in self.read_by:
            return True
        has_source = not self.sources or type(feedback.source) in self.sources
        return has_source and feedback.type.name in self.accepts


def _validate(name: str, entry: object) -> ModifierType:
    if not isinstance(entry, ModifierType):
        raise PluginError(f"is a {type(entry).__name__}, not a ModifierType")
    unknown = sorted(entry.accepts - TYPES.keys())
    if unknown or not entry.accepts:
        raise PluginError(f"accepts {', '.join(unknown) or 'no type'}; types: {', '.join(TYPES)}")
    places = [place for place in (entry.implementation, entry.slot) if place]
    if entry.name != name or not places or any(place.count(":") != 1 for place in places):
        made = " and ".join(places) or "nothing"
        raise PluginError(f"calls itself '{entry.name}', made by '{made}'")
    return entry


_OWN = ("free_axis", "standoff", "funnel", "seek", "requires", "onset")

MODIFIERS: Registry[ModifierType] = Registry(
    "modifier",
    "cbdsl.modifiers",
    {name: f"cbdsl.runtime.modifiers.{name}:{name.upper()}" for name in _OWN},
    _validate,
)


def declared(controller: object) -> Iterator[tuple[ModifierType, Any]]:
    """Yield the built-in modifiers of a controller, with their options.

    Args:
        controller: Checked controller, or the section of a document.
    """
    for name in MODIFIERS.builtins:
        options = getattr(controller, name)
        if options is not None:
            yield MODIFIERS.get(name), options
