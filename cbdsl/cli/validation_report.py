"""The result of ``cb validate``, before it is formatted."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import NamedTuple

from cbdsl.errors.diagnostic import Diagnostic, Severity


class ValidationReport(NamedTuple):
    """The findings of one run.

    Attributes:
        findings: by file and place.
        documents: how many were checked.
        left_out: how many more findings there are than any person could mend at once.
        text_of: the text of a file, or ``None`` where it has none.
        others: Number of YAML files of other tools that were skipped.
        unreadable: Number of folders that cannot be read.
    """

    findings: tuple[Diagnostic, ...]
    documents: int
    left_out: int
    text_of: Callable[[str], str | None]
    others: int = 0
    unreadable: int = 0

    @property
    def errors(self) -> int:
        """How many findings are errors."""
        return self._count(Severity.ERROR)

    @property
    def warnings(self) -> int:
        """How many findings are warnings."""
        return self._count(Severity.WARNING)

    @property
    def notes(self) -> int:
        """How many findings tell what is assumed, and ask for nothing."""
        return self._count(Severity.NOTE)

    def without_notes_elsewhere(self, files: Collection[str]) -> ValidationReport:
        """The same without the notes on other files than these."""
        kept = (
            finding
            for finding in self.findings
            if finding.severity is not Severity.NOTE or finding.place.file in files
        )
        return self._replace(findings=tuple(kept))

    def _count(self, severity: Severity) -> int:
        return sum(diagnostic.severity is severity for diagnostic in self.findings)
