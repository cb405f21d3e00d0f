"""Kinds of documents, for the entry-point group ``cbdsl.documents``.

An entry is a ``Kind``: a pydantic model, the folder of its names, the place of a checker ``(Loaded,
Session, Diagnostics) -> None``, and the diagnostics that the checker may add. A checker reports
faults with their places and raises nothing. The contract test is
``cbdsl.extend.contract.test_document``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.checking.lookup.document_search import find_document
    from cbdsl.checking.session import Session
    from cbdsl.diagnostics.diagnostics import Diagnostics
    from cbdsl.diagnostics.entry import Entry
    from cbdsl.diagnostics.outcome import Unknown
    from cbdsl.documents.document import NAME_PATTERN, Document, Duration, Name, Section, quantity
    from cbdsl.documents.kind import Kind
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.yaml_text.loaded import Loaded

__all__ = [
    "NAME_PATTERN",
    "Diagnostics",
    "Document",
    "Duration",
    "Entry",
    "Kind",
    "Loaded",
    "Name",
    "ProgramDocument",
    "RobotDocument",
    "Section",
    "Session",
    "StageDocument",
    "Unknown",
    "find_document",
    "quantity",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
