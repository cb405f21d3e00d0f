"""A document and the places of its parts."""

from __future__ import annotations

from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

from pydantic_core import ErrorDetails

from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.documents.document import Document
from cbdsl.yaml_text.source_map import SourceMap

D = TypeVar("D", bound=Document, covariant=True)


class Invalid(NamedTuple):
    """Errors of a document.

    Attributes:
        model: Model of the kind of document.
        errors: Errors of its validation.
    """

    model: type[Document]
    errors: tuple[ErrorDetails, ...]


class Loaded(NamedTuple, Generic[D]):
    """Document and the places of its parts.

    Attributes:
        document: Document without its faulty parts.
        source: Source map of the document.
        diagnostics: Diagnostics about the text; ``source.broken`` lists the omitted parts.
        taken: Names of a program's controllers and conditions that stand for calls of shared ones.
        shared_faults: Diagnostics about the shared documents that it takes up, and their calls.
    """

    document: D
    source: SourceMap
    diagnostics: tuple[Diagnostic, ...] = ()
    taken: frozenset[str] = frozenset()
    shared_faults: tuple[Diagnostic, ...] = ()

    @property
    def path(self) -> Path:
        """File of the document."""
        return self.source.path
