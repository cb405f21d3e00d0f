"""Report of one run of ``cb validate``, which the writers format."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.diagnostics.diagnostic import FAILED_CHECK, Diagnostic, Severity

if TYPE_CHECKING:
    from cbdsl.diagnostics.entry import Entry


def _no_entry(code: str) -> None:
    """Return no entry, for reports whose codes are not looked up."""


class ValidationReport(NamedTuple):
    """Diagnostics of one run.

    Attributes:
        diagnostics: Diagnostics by file and place.
        documents: Number of checked documents.
        left_out: Number of diagnostics omitted beyond the limit per file.
        text_of: Function that returns the text of a file, or ``None`` if it has none.
        others: Number of YAML files of other tools that were skipped.
        unreadable: Number of folders that cannot be read.
        entry_of: Function that returns the entry of a code, also of a plug-in.
    """

    diagnostics: tuple[Diagnostic, ...]
    documents: int
    left_out: int
    text_of: Callable[[str], str | None]
    others: int = 0
    unreadable: int = 0
    entry_of: Callable[[str], Entry | None] = _no_entry

    @property
    def errors(self) -> int:
        """Number of errors."""
        return self._count(Severity.ERROR)

    @property
    def warnings(self) -> int:
        """Number of warnings."""
        return self._count(Severity.WARNING)

    @property
    def notes(self) -> int:
        """Number of notes, which state assumptions and require no action."""
        return self._count(Severity.NOTE)

    def exit_code(self, strict: bool) -> int:
        """Return 0 without errors, 1 with errors, and 2 if a check failed.

        Args:
            strict: True if warnings count as errors.
        """
        # A failed check leaves the document undecided, which outweighs its other errors.
        if any(diagnostic.code == FAILED_CHECK for diagnostic in self.diagnostics):
            return 2
        return 1 if self.errors or (strict and self.warnings) else 0

    def without_notes_elsewhere(self, files: Collection[str]) -> ValidationReport:
        """Return the report without notes on files other than these."""
        kept = (
            diagnostic
            for diagnostic in self.diagnostics
            if diagnostic.severity is not Severity.NOTE or diagnostic.place.file in files
        )
        return self._replace(diagnostics=tuple(kept))

    def _count(self, severity: Severity) -> int:
        return sum(diagnostic.severity is severity for diagnostic in self.diagnostics)
