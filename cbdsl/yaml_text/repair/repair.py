"""Repair of faulty texts: the single entry point to all corrections."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.wording import diagnose
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_name
from cbdsl.yaml_text.composer import Composed
from cbdsl.yaml_text.loaded import Invalid, Loaded
from cbdsl.yaml_text.repair.kind_identification import identify
from cbdsl.yaml_text.repair.mending import mend
from cbdsl.yaml_text.repair.salvage import salvage
from cbdsl.yaml_text.source_map import SourceMap

D = TypeVar("D", bound=Document)


def repair(
    path: Path,
    kind: type[D],
    text: str,
    composed: Composed | None = None,
    invalid: Invalid | None = None,
) -> Loaded[D]:
    """Return the sound parts of a document of one kind, with all faults of its text.

    Args:
        path: File of the document.
        kind: Required kind of document.
        text: Text of the file.
        composed: Nodes of the text, if they are already composed.
        invalid: Errors of these nodes, if they are already validated.

    Raises:
        DiagnosticsError: No part of the document can be checked.
    """
    composed = mend(text, str(path), composed)
    source = SourceMap(path, composed.lines, composed.root)
    _require_version(source)
    model, diagnostics = identify(source, composed.diagnostics)
    if not issubclass(model, kind):
        place, given = source.place("kind"), str(source.node(("kind",)).value)
        wrong = diagnose("CB201", place, wanted=kind_name(kind), found=given)
        raise DiagnosticsError([wrong])
    is_validated = invalid is not None and invalid.model is model and not diagnostics
    errors = invalid.errors if invalid is not None and is_validated else ()
    return salvage(source, model, diagnostics, errors)


def _require_version(source: SourceMap) -> None:
    """Refuse a later version of the language, whose keys may have other meanings.

    Raises:
        DiagnosticsError: The document declares a later version.
    """
    root = source.root.value
    version = root.get("cbdsl") if isinstance(root, dict) else None
    if version is not None and isinstance(version.value, int) and version.value > 1:
        raise DiagnosticsError([diagnose("CB240", version.place, version=version.value)])
