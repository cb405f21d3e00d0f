"""A document and where its parts stand."""

from __future__ import annotations

from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

from cbdsl.documents.document import Document
from cbdsl.errors.diagnostic import Diagnostic
from cbdsl.yaml_text.source_map import SourceMap

D = TypeVar("D", bound=Document, covariant=True)


class Loaded(NamedTuple, Generic[D]):
    """A document and where its parts stand.

    Attributes:
        document: without what is faulty.
        source: its text.
        faults: findings about the text; ``source.broken`` says what was left out.
    """

    document: D
    source: SourceMap
    faults: tuple[Diagnostic, ...] = ()

    @property
    def path(self) -> Path:
        """Its file."""
        return self.source.path
