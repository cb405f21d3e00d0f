"""Modifiers: kinds of change to a controller's reference, which packages add."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.types.registry import PluginError, Registry
from cbdsl.types.resource_type import TYPES


class ModifierType(NamedTuple):
    """A change of a controller's reference in every tick.

    Attributes:
        name: its name in programs.
        summary: its effect, as a phrase.
        accepts: names of the resource types whose references it changes.
        options: dimension of each option, as of ``unit.UNITS``; empty for a plain number.
        implementation: ``module:function`` of (reference, feedback, time, options) -> reference:
            values of the rows, shape (m,), simulated time, s, and options by name, in SI.
    """

    name: str
    summary: str
    accepts: frozenset[str]
    options: Mapping[str, str]
    implementation: str


def _validate(name: str, entry: object) -> ModifierType:
    if not isinstance(entry, ModifierType):
        raise PluginError(f"is a {type(entry).__name__}, not a ModifierType")
    unknown = sorted(entry.accepts - TYPES.keys())
    if unknown or not entry.accepts:
        raise PluginError(f"accepts {', '.join(unknown) or 'no type'}; types: {', '.join(TYPES)}")
    if entry.name != name or entry.implementation.count(":") != 1:
        raise PluginError(f"calls itself '{entry.name}', made by '{entry.implementation}'")
    return entry


MODIFIERS: Registry[ModifierType] = Registry("modifier", "cbdsl.modifiers", {}, _validate)
