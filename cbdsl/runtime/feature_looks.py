"""Looks for features that a program's first choice needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.context import ContextReader


class LookingProgram(Protocol):
    """A run of a program that looks for a feature; see ``ProgramRun``."""

    predicate: str

    def activate(self) -> None: ...
    def advance(self) -> None: ...
    def deactivate(self) -> None: ...
    def active(self) -> Sequence[Active]: ...


class FeatureLooks:
    """Programs that look for undefined features, one after the other.

    Args:
        programs: that look, by feature.
        context: whose features they are; where there is none, nothing is looked for.

    Attributes:
        current: the program that looks now, if one does.
    """

    def __init__(
        self, programs: Mapping[str, LookingProgram], context: ContextReader | None
    ) -> None:
        self._programs, self._context = programs, context
        self.forget()

    def forget(self) -> None:
        """Look for nothing more."""
        self.current: LookingProgram | None = None
        self._pending: list[str] = []

    def begin(self) -> bool:
        """Look for the first feature that is undefined; whether there is one."""
        self._pending = list(self._programs)
        return self._next()

    def advance(self, look: LookingProgram) -> bool:
        """Go on with the current program, and with the next one once that ended; whether one looks.

        Args:
            look: the current one.
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
