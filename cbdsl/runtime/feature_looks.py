"""Searches for the features that a program's first choice needs."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.runtime.child_run import ChildRun
from cbdsl.runtime.context_reader import ContextReader


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
