"""A finding: what is wrong, where, and what would have been right."""

from enum import Enum
from typing import NamedTuple

from cbdsl.errors.nearest import nearest_name


class Severity(Enum):
    """Errors keep a document from being used; warnings do not, and notes tell what is assumed."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


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
        given: the name that was written instead.
        candidates: what its ``nearest`` is chosen from, where that is not ``allowed``.
        related: other places that the message speaks of.
    """

    code: str
    message: str
    place: Place
    severity: Severity = Severity.ERROR
    allowed: tuple[str, ...] = ()
    given: str = ""
    candidates: tuple[str, ...] = ()
    related: tuple[Related, ...] = ()

    @property
    def nearest(self) -> str | None:
        """The name that was probably meant; looked for only when somebody wants to know."""
        return nearest_name(self.given, self.candidates or self.allowed)

    @property
    def is_error(self) -> bool:
        """Whether it keeps the document from being used."""
        return self.severity is Severity.ERROR
