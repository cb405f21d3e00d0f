"""Exceptions that carry a user's mistakes to the command line."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Self

from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.nearest import suggestion


class DiagnosticsError(Exception):
    """Error of a faulty document; ``diagnostics`` holds all its diagnostics."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__("\n".join(f"{d.place}: {d.code} {d.message}" for d in self.diagnostics))


class UsageError(Exception):
    """User's mistake that has no place in a file."""

    @classmethod
    def unknown(cls, noun: str, name: str, known: Iterable[str]) -> Self:
        """Return the error of an unknown name, which proposes the nearest and lists all names.

        Args:
            noun: Noun of the named objects.
            name: Unknown name.
            known: Existing names.
        """
        names = list(known)
        listed = ", ".join(names) or "none"
        return cls(f"unknown {noun} '{name}'{suggestion(name, names)} (known: {listed})")
