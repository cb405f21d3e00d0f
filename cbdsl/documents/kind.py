"""The record of one kind of document, built in or added by another package."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cbdsl.documents.document import Document

if TYPE_CHECKING:
    from cbdsl.diagnostics.entry import Entry


class Kind(NamedTuple):
    """Kind of document: its model, its folder, its checker and its diagnostics.

    Attributes:
        model: Model of the keys, with ``kind: Literal["<name>"]`` among them.
        folder: Folder, below a root, in which documents of this kind are looked up by name.
        checker: ``module:function`` of a ``Loaded`` document, the ``Session`` and
            ``Diagnostics``.
        unknown: Diagnostic for an unknown name, filled with ``name`` and ``hint``: a code of the
            catalogue or an entry of ``entries``.
        references: Kinds of the documents that top-level keys name, by key.
        stand_ins: Values that replace missing required keys, so that the other keys are checked.
        entries: Diagnostics of the checker that the catalogue does not have.
        resources: ``module:function`` of (alias, loaded, body, diagnostics) that returns the
            resources which a program gains by naming a document of this kind below ``models``;
            unknown if the document does not fit the robot. Empty for other kinds.
        brought: Folder of documents that the package of the kind brings along, searched last.
    """

    model: type[Document]
    folder: str
    checker: str
    unknown: str | Entry
    references: Mapping[str, str] = {}
    stand_ins: Mapping[str, Any] = {}
    entries: tuple[Entry, ...] = ()
    resources: str = ""
    brought: Path | None = None
