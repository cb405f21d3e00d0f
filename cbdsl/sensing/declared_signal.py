"""Readers of sensors and models from other packages, whose errors name the package."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from cbdsl.documents.kinds import KINDS
from cbdsl.robot.source_kind import SOURCES
from cbdsl.sensing.sensor_faults import SensorError
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.resource import ModelSignal, SensorSignal
from cbdsl.types.resource_type import ORIENTATION, ResourceType


def declared_reader(
    signal: SensorSignal | ModelSignal, kind: ResourceType, joints: int, signals: Any
) -> Callable[[], Reading | None]:
    """Return the reader of a sensor or model from another package, whose errors name the package.

    Args:
        signal: Signal of the sensor or model.
        kind: Type of the value.
        joints: Number of columns of the Jacobian, if there is one.
        signals: Signals of the robot.

    Raises:
        PluginError: The package's function raises. The reader also raises it, or SensorError if a
            value is not finite.
    """
    asked: Any = signal
    is_model = hasattr(asked, "reader")
    place = asked.reader if is_model else SOURCES.get(asked.kind).reader
    name = f"the model {asked.model}" if is_model else f"the sensor {asked.sensor}"
    failed = partial((KINDS if is_model else SOURCES).fault, asked.kind)
    module, function = place.split(":")
    try:
        make = getattr(import_module(module), function)
        reader: Callable[[], Reading | None] = make(signal, signals)
    except Exception as error:
        raise failed(f"{type(error).__name__}: {error}") from error

    def read() -> Reading | None:
        try:
            reading = reader()
            _require_shape(reading, (3, 3) if kind == ORIENTATION else (kind.size,), joints)
        except Exception as error:
            raise failed(f"{type(error).__name__}: {error}") from error
        if reading is not None and not np.isfinite(reading.value).all():
            raise SensorError(f"{name} is not finite")
        return reading

    return read


def _require_shape(reading: Reading | None, shape: tuple[int, ...], joints: int) -> None:
    """Raise an error for a reading of another package that does not fit its row.

    Raises:
        ValueError: The value or the Jacobian has another shape.
    """
    if reading is None:
        return
    if reading.value.shape != shape:
        raise ValueError(f"its value has shape {reading.value.shape}, not {shape}")
    if reading.jacobian is not None and reading.jacobian.shape != (shape[0], joints):
        size = reading.jacobian.shape
        raise ValueError(f"its Jacobian has shape {size}, not {(shape[0], joints)}")
