"""Context of a schema: its features, read from the robot's own signals."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cbdsl.program.schema import Schema, components
from cbdsl.sensing.signals import Signals


class ContextReader:
    """Reader of the features by which a schema allocates.

    Args:
        schema: Schema that names the features.
        signals: Signals of the robot.
    """

    def __init__(self, schema: Schema, signals: Signals) -> None:
        self._signals = signals
        self._bound = {name: signals.bind(each) for name, each in schema.features.items()}
        self._rows = [
            (self._bound[name], tuple(components(name, resource)))
            for name, resource in schema.features.items()
        ]

    def lacks(self, feature: str) -> bool:
        """Return whether a feature is undefined now."""
        return self._signals.reading(self._bound[feature]) is None

    def read(self) -> Mapping[str, float]:
        """Return the current numbers of all features, by name, in SI; NaN while undefined."""
        numbers: dict[str, float] = {}
        for row, names in self._rows:
            reading = self._signals.reading(row)
            values = [math.nan] * len(names) if reading is None else reading.value.ravel().tolist()
            numbers.update(zip(names, values, strict=True))
        return numbers
