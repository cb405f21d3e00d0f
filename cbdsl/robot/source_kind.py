"""Kinds of sensors from packages, declared below ``sensors`` in a robot document."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from cbdsl.documents.robot import RobotDocument, Sensor
from cbdsl.types.registry import PluginError, Registry
from cbdsl.types.resource import Origin, Resource, SensorSignal
from cbdsl.types.resource_type import ResourceType

Signals = Mapping[str, ResourceType]
"""Types of a sensor's signals, by the parts of their names after the sensor's name."""


class SourceKind(NamedTuple):
    """Kind of sensor.

    Attributes:
        name: Name in robot documents.
        summary: Quantity of the sensor, as a phrase.
        signals: Types of its signals by part, or a function of a sensor's section and the robot
            that returns them.
        reader: ``module:function`` of (signal, signals) -> reader. From a ``SensorSignal`` and the
            robot's ``Signals``, it returns a function for this tick's ``Reading``, or ``None``
            while the signal is undefined.
        needs: Keys of the section without which a sensor has no signals.
        origin: Origin of its signals.
    """

    name: str
    summary: str
    signals: Signals | Callable[[Sensor, RobotDocument], Signals]
    reader: str
    needs: tuple[str, ...] = ("link",)
    origin: Origin = Origin.ENVIRONMENT

    def resources(self, name: str, sensor: Sensor, robot: RobotDocument) -> Iterator[Resource]:
        """Yield the typed signals of a sensor; none if its section is incomplete.

        Args:
            name: Name of the sensor.
            sensor: Section of the sensor.
            robot: Robot document with the section.
        """
        cells = {} if sensor.hand is None else robot.load_cells.get(sensor.hand, {})
        given = {"link": sensor.link, "hand": cells, "options": sensor.options}
        if not all(given[key] for key in self.needs):
            return
        parts = self.signals(sensor, robot) if callable(self.signals) else self.signals
        # A sensor at a link moves with the link, and a sensor without one with the hand.
        links = (
            tuple(cell.link for cell in cells.values()) if sensor.link is None else (sensor.link,)
        )
        for part, kind in parts.items():
            source = SensorSignal(name, self.name, part, links)
            yield Resource(f"{name}.{part}", kind, self.origin, source)


#: Keys of a sensor's section that a kind may need.
_KEYS = ("link", "hand", "options")


def _validate(name: str, entry: object) -> SourceKind:
    if not isinstance(entry, SourceKind):
        raise PluginError(f"is a {type(entry).__name__}, not a SourceKind")
    if entry.name != name or entry.reader.count(":") != 1:
        raise PluginError(f"calls itself '{entry.name}', read by '{entry.reader}'")
    if not callable(entry.signals) and not _are_types(entry.signals):
        raise PluginError("gives as signals neither types by name nor a function")
    if unknown := [key for key in entry.needs if key not in _KEYS]:
        raise PluginError(f"needs {', '.join(unknown)}; keys of a sensor: {', '.join(_KEYS)}")
    return entry


def _are_types(signals: object) -> bool:
    types = signals.values() if isinstance(signals, Mapping) else [None]
    return all(isinstance(kind, ResourceType) for kind in types)


SOURCES: Registry[SourceKind] = Registry("kind of sensor", "cbdsl.sources", {}, _validate)
