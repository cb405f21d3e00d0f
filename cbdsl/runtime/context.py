"""The context of a schema: its features, read from the robot's own signals."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cbdsl.program.schema import Schema, components
from cbdsl.sensing.signals import Signals


class ContextReader:
    """Reads the features by which a schema allocates.

    Args:
        schema: names them.
        signals: of the robot.
    """

    def __init__(self, schema: Schema, signals: Signals) -> None:
        self._signals = signals
        self._rows = [
            (signals.bind(resource), tuple(components(name, resource)))
            for name, resource in schema.features.items()
        ]

    def read(self) -> Mapping[str, float]:
        """The numbers of all features now, by name, in SI; NaN where a signal is undefined."""
        numbers: dict[str, float] = {}
        for row, names in self._rows:
            reading = self._signals.reading(row)
            values = [math.nan] * len(names) if reading is None else reading.value.ravel().tolist()
            numbers.update(zip(names, values, strict=True))
        return numbers
