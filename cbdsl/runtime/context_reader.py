"""Context of a schema: its features, read from the robot's own signals."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cbdsl.program.schema import Schema, components
from cbdsl.runtime.action_runs import ChildRun
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


class FeatureLooks:
    """Sequence of programs that search for undefined features.

    Args:
        programs: Search programs by feature.
        context: Reader of the features; without one nothing is searched.

    Attributes:
        current: Program that searches now, if any.
    """

    def __init__(self, programs: Mapping[str, ChildRun], context: ContextReader | None) -> None:
        self._programs, self._context = programs, context
        self.forget()

    def forget(self) -> None:
        """End all searches."""
        self.current: ChildRun | None = None
        self._pending: list[str] = []

    def begin(self) -> bool:
        """Search for the first undefined feature; return whether there is one."""
        self._pending = list(self._programs)
        return self._next()

    def advance(self, look: ChildRun) -> bool:
        """Advance the current search, or begin the next after its end; return whether one runs.

        Args:
            look: Current search program.
        """
        look.advance()
        if look.predicate == "0":
            return True
        look.deactivate()
        return self._next()

    def _next(self) -> bool:
        while self._pending and self._context is not None:
            feature = self._pending.pop(0)
            if self._context.lacks(feature):
                self.current = self._programs[feature]
                self.current.activate()
                return True
        self.current = None
        return False
