"""A finding: what is wrong, where, and what would have been right."""

from enum import Enum
from typing import NamedTuple


class Severity(Enum):
    """Errors keep a document from being used; warnings do not."""

    ERROR = "error"
    WARNING = "warning"


class Place(NamedTuple):
    """A stretch of one line of a file.

    Attributes:
        file: as the user wrote it or would find it.
        line: from 1.
        column: first character, from 1.
        end_column: the character after the last.
    """

    file: str
    line: int = 1
    column: int = 1
    end_column: int = 2

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


class Related(NamedTuple):
    """Another place that a finding speaks of, and what is there."""

    place: Place
    message: str


class Diagnostic(NamedTuple):
    """One finding.

    Attributes:
        code: its entry in the catalogue.
        message: one sentence without a full stop.
        place: where.
        severity: whether the document can still be used.
        allowed: names that would have been right, possibly shortened.
        nearest: the one that was probably meant.
        related: other places that the message speaks of.
    """

    code: str
    message: str
    place: Place
    severity: Severity = Severity.ERROR
    allowed: tuple[str, ...] = ()
    nearest: str | None = None
    related: tuple[Related, ...] = ()

    @property
    def is_error(self) -> bool:
        """Whether it keeps the document from being used."""
        return self.severity is Severity.ERROR
