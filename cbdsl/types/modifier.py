"""Modifiers: kinds of change to what a controller does, built in or added by packages."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from cbdsl.types.registry import PluginError, Registry
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import TYPES

Call = Callable[[str | None, str], str | None]
"""Name of another controller, from how a program calls it and the option that says so."""


class OptionFault(NamedTuple):
    """A fault of a modifier's options.

    Attributes:
        option: that is told of.
        code: of the finding.
        details: that fill it.
    """

    option: str
    code: str
    details: Mapping[str, str]


class ModifierType(NamedTuple):
    """A change of a controller: of its reference in every tick, or of its slot in the plan.

    A modifier of another package stands below ``modifiers`` in a program. One of cbdsl's own is a
    key of the controller, and a field of the checked one.

    Attributes:
        name: its name in programs.
        summary: its effect, as a phrase.
        accepts: names of the types of feedback that it is for.
        options: dimension of each option, as of ``unit.UNITS``; empty for a plain number.
        implementation: ``module:function`` of (reference, feedback, time, options) -> reference:
            values of the rows, shape (m,), simulated time, s, and options by name, in SI; empty
            where it does not change references.
        slot: ``module:function`` of (form, options, setting) -> form, of ``plan.SlotForm`` and
            ``runtime.slot_setting.SlotSetting``, called when a controller gets its slot; empty
            where it does not change slots.
        sources: kinds of sources of the feedback that it is for; any without.
        purpose: the feedback that it is for, in messages.
        residual: whether it changes residuals, which a potential that is a field has none of.
        read: makes the checked controller's field of the document's.
        fault: the fault of the document's options, or ``None``.
        read_by: potentials that read its options themselves, for whatever feedback they have.
        positive, not_negative: options that have to be above 0, or not below.
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
        """Whether it is for a feedback under a potential."""
        if potential in self.read_by:
            return True
        has_source = not self.sources or isinstance(feedback.source, self.sources)
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
    """Modifiers of cbdsl's own that a controller has, with their options.

    Args:
        controller: a checked one, or the section of a document.
    """
    for name in MODIFIERS.builtins:
        options = getattr(controller, name)
        if options is not None:
            yield MODIFIERS.get(name), options
