"""Kinds of documents, for the entry-point group ``cbdsl.documents``.

An entry is a ``Kind``: a pydantic model, the folder of its names, the place of a checker ``(Loaded,
Session, Diagnostics) -> None``, and the diagnostics that the checker may add. A checker reports
faults with their places and raises nothing. The contract test is
``cbdsl.extend.contract.test_document``.

A kind may also be one of models, which programs name below ``models``. Its record then has the
place of a function of (alias, Loaded, CheckedRobot, Diagnostics) that returns the resources which
such a program gains. The source of a resource is a ``ModelSignal``, with the place of a function
(ModelSignal, Signals) -> Read, as of ``cbdsl.extend.source``.

A kind may bring documents along, such as programs that use it: its record names a folder with
``programs``, ``knowledge`` and the like, which are found by name after all others.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.checking.knowledge.program_digest import program_digest
    from cbdsl.checking.lookup.document_search import find_document
    from cbdsl.checking.robot.checked_robot import CheckedRobot
    from cbdsl.checking.session import Session
    from cbdsl.diagnostics.diagnostic import Place
    from cbdsl.diagnostics.diagnostics import Diagnostics
    from cbdsl.diagnostics.entry import Entry
    from cbdsl.diagnostics.lines import lines_of
    from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
    from cbdsl.documents.document import (
        NAME_PATTERN,
        Document,
        Duration,
        Name,
        PositiveCount,
        Section,
        quantity,
    )
    from cbdsl.documents.file_section import FileSection
    from cbdsl.documents.kind import Kind
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.shared import SharedDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.editor.fixes import Fix, replaced
    from cbdsl.language.parameters import parameters_in
    from cbdsl.storage.contents import contents
    from cbdsl.storage.digest import digest_of_bytes
    from cbdsl.types.resource import ModelSignal, Origin, Resource
    from cbdsl.types.resource_type import ResourceType
    from cbdsl.yaml_text.composer import compose
    from cbdsl.yaml_text.library import Library, is_of
    from cbdsl.yaml_text.loaded import Loaded
    from cbdsl.yaml_text.node import Node
    from cbdsl.yaml_text.shared_calls import terms_of
    from cbdsl.yaml_text.shared_parts import SharedPart
    from cbdsl.yaml_text.source_map import SourceMap

__all__ = [
    "NAME_PATTERN", "UNKNOWN", "CheckedRobot", "Diagnostics", "Document", "Duration", "Entry",
    "FileSection", "Fix", "Kind", "Library", "Loaded", "ModelSignal", "Name", "Node", "Origin",
    "Outcome", "Place", "PositiveCount", "ProgramDocument", "Resource", "ResourceType",
    "RobotDocument", "Section", "Session", "SharedDocument", "SharedPart", "SourceMap",
    "StageDocument", "Unknown", "compose", "contents", "digest_of_bytes", "find_document", "is_of",
    "lines_of", "parameters_in", "program_digest", "quantity", "replaced", "terms_of",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
