"""The exceptions that carry a user's mistakes to the command line."""

from __future__ import annotations

from collections.abc import Iterable

from cbdsl.errors.diagnostic import Diagnostic


class DiagnosticsError(Exception):
    """A document has faults; ``diagnostics`` names all that were found."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__("\n".join(f"{d.place}: {d.code} {d.message}" for d in self.diagnostics))


class UsageError(Exception):
    """A mistake of the user's that has no place in a file."""
