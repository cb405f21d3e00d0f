"""Kinds of drivers: transports between a robot document and a real robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from cbdsl.documents.driver import Driver
from cbdsl.types.registry import PluginError, Registry

Steps = tuple[str, ...]
Problem = tuple[Steps, str]
"""Path of a value in a driver's section, and the reason why it cannot work."""


class DriverKind(NamedTuple):
    """Kind of driver.

    Attributes:
        name: Name in robot documents.
        summary: Transport, as a phrase.
        problems: Values of a driver's section that this kind cannot use.
        link: ``module:function`` that opens drivers; see ``cbdsl.extend.driver``.
    """

    name: str
    summary: str
    problems: Callable[[Driver], Iterable[Problem]]
    link: str


def _validate(name: str, entry: object) -> DriverKind:
    if not isinstance(entry, DriverKind):
        raise PluginError(f"is a {type(entry).__name__}, not a DriverKind")
    if entry.name != name or entry.link.count(":") != 1 or not callable(entry.problems):
        raise PluginError(f"calls itself '{entry.name}', opened by '{entry.link}'")
    return entry


DRIVERS: Registry[DriverKind] = Registry(
    "driver kind", "cbdsl.drivers", {}, _validate, providers={"ros2": "cbdsl[ros2]"}
)
