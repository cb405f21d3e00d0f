"""Diagnostics as they gather during one pass."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from cbdsl.errors.diagnostic import Diagnostic, Place
from cbdsl.errors.wording import diagnostic


class Findings:
    """All findings so far, each once, in the order of discovery."""

    def __init__(self) -> None:
        self._found: dict[Diagnostic, None] = {}

    def add(self, code: str, place: Place, **details: Any) -> None:
        """Add a finding in the catalogue's words; see ``diagnostic``."""
        self.extend([diagnostic(code, place, **details)])

    def extend(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Add findings made elsewhere."""
        self._found.update(dict.fromkeys(diagnostics))

    @property
    def failed(self) -> bool:
        """Whether there is an error among them."""
        return any(found.is_error for found in self._found)

    def sorted(self) -> tuple[Diagnostic, ...]:
        """All of them by place."""
        return tuple(sorted(self._found, key=lambda found: (found.place, found.code)))
