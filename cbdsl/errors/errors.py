"""The exceptions that carry a user's mistakes to the command line."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Self

from cbdsl.errors.diagnostic import Diagnostic
from cbdsl.errors.nearest import suggestion


class DiagnosticsError(Exception):
    """A document has faults; ``diagnostics`` names all that were found."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__("\n".join(f"{d.place}: {d.code} {d.message}" for d in self.diagnostics))


class UsageError(Exception):
    """A mistake of the user's that has no place in a file."""

    @classmethod
    def unknown(cls, what: str, name: str, known: Iterable[str]) -> Self:
        """Nothing has this name: the nearest is proposed, and all are listed.

        Args:
            what: what has names of this sort.
            name: the one that was given.
            known: those that there are.
        """
        names = list(known)
        listed = ", ".join(names) or "none"
        return cls(f"there is no {what} '{name}'{suggestion(name, names)} (known: {listed})")
