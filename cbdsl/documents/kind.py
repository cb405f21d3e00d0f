"""The record of one kind of document, built in or added by another package."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from cbdsl.documents.document import Document

if TYPE_CHECKING:
    from cbdsl.errors.entry import Entry


class Kind(NamedTuple):
    """Everything that readers, checkers and commands know of one kind of document.

    Attributes:
        model: its keys; ``kind: Literal["<name>"]`` among them.
        folder: where documents of this kind are looked up by name, below a root.
        checker: ``module:function``, called with a ``Loaded`` document, the ``Session`` and the
            ``Findings``.
        unknown: finding for a name that no document of this kind has, filled with ``name`` and
            ``hint``: a code of the catalogue or an entry of ``entries``.
        references: kinds of the documents that top-level keys name, by key.
        stand_ins: values for required keys that are missing, so that the rest is checked.
        entries: findings of the checker that the catalogue does not have.
    """

    model: type[Document]
    folder: str
    checker: str
    unknown: str | Entry
    references: Mapping[str, str] = {}
    stand_ins: Mapping[str, Any] = {}
    entries: tuple[Entry, ...] = ()
