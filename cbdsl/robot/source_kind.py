"""Kinds of sensors from packages, declared below ``sensors`` in a robot document."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from cbdsl.documents.robot import RobotDocument, Sensor
from cbdsl.types.registry import PluginError, Registry
from cbdsl.types.resource import Resource


class SourceKind(NamedTuple):
    """Kind of sensor.

    Attributes:
        name: Name in robot documents.
        summary: Quantity of the sensor, as a phrase.
        resources: Function of a sensor's name, its section and the robot that yields the typed
            signals; the source of each is a ``SensorSignal``.
        reader: ``module:function`` of (signal, signals) -> reader. From a ``SensorSignal`` and the
            robot's ``Signals``, it returns a function for this tick's ``Reading``, or ``None``
            while the signal is undefined.
    """

    name: str
    summary: str
    resources: Callable[[str, Sensor, RobotDocument], Iterable[Resource]]
    reader: str


def _validate(name: str, entry: object) -> SourceKind:
    if not isinstance(entry, SourceKind):
        raise PluginError(f"is a {type(entry).__name__}, not a SourceKind")
    if entry.name != name or entry.reader.count(":") != 1 or not callable(entry.resources):
        raise PluginError(f"calls itself '{entry.name}', read by '{entry.reader}'")
    return entry


SOURCES: Registry[SourceKind] = Registry("kind of sensor", "cbdsl.sources", {}, _validate)
