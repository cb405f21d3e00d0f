"""Kinds of sensors, for the entry-point group ``cbdsl.sources``.

An entry is a ``SourceKind``: the types of a sensor's signals, for the checker, and the place of a
function ``(SensorSignal, Signals) -> Read``, called once a run. ``Read`` returns the ``Reading`` of
this tick, with its value in SI units, shape (m,), and its Jacobian by the robot's joints, shape (m,
n); or ``None`` while the signal is undefined. An exception or a number that is not finite ends the
episode with the name of the package. The contract test is ``cbdsl.extend.contract.test_source``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.documents.robot import RobotDocument, Sensor
    from cbdsl.robot.source_kind import SourceKind
    from cbdsl.sensing.signals import Signals
    from cbdsl.sensing.table.reading import Reading
    from cbdsl.types.resource import Origin, SensorSignal
    from cbdsl.types.resource_type import (
        DISTANCE,
        FORCE,
        HEADING,
        ORIENTATION,
        POSE,
        POSITION,
        TORQUE,
        TYPES,
        WRENCH,
        ResourceType,
    )

__all__ = [
    "DISTANCE", "FORCE", "HEADING", "ORIENTATION", "POSE", "POSITION", "TORQUE", "TYPES", "WRENCH",
    "Origin", "Read", "Reading", "ResourceType", "RobotDocument", "Sensor", "SensorSignal",
    "Signals", "SourceKind",
]  # fmt: skip

__getattr__ = lazy_names(__file__)

Read = Callable[[], "Reading | None"]
"""Function that returns the reading of a signal in this tick, or ``None`` if it is undefined."""
