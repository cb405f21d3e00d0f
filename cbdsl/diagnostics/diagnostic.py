"""Diagnostics: a message, its place in a file, and the allowed names."""

from enum import Enum
from typing import NamedTuple

from cbdsl.diagnostics.legible_text import one_line
from cbdsl.diagnostics.nearest import nearest_name

#: Code of the diagnostic that reports a failed check.
FAILED_CHECK = "CB901"


class Severity(Enum):
    """Severity: errors prevent the use of a document, warnings do not, notes state assumptions."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


class Place(NamedTuple):
    """A stretch of one line of a file.

    Attributes:
        file: File name as the user wrote it or would find it.
        line: Line number, from 1.
        column: Column of the first character, from 1.
        end_column: Column after the last character.
    """

    file: str
    line: int = 1
    column: int = 1
    end_column: int = 2

    def __str__(self) -> str:
        return f"{one_line(self.file)}:{self.line}:{self.column}"


class Related(NamedTuple):
    """Another place that a diagnostic mentions, with a message about it."""

    place: Place
    message: str


class Diagnostic(NamedTuple):
    """One diagnostic.

    Attributes:
        code: Code of its entry in the catalogue.
        message: One sentence without a full stop.
        place: Place in a file.
        severity: Severity, which decides whether the document can still be used.
        allowed: Allowed names, possibly shortened.
        given: Name that was written instead.
        candidates: Names from which ``nearest`` is chosen; empty for ``allowed``.
        related: Other places that the message mentions.
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
        """Most similar candidate to the given name, computed on access."""
        return nearest_name(self.given, self.candidates or self.allowed)

    @property
    def is_error(self) -> bool:
        """True if the diagnostic prevents the use of the document."""
        return self.severity is Severity.ERROR
