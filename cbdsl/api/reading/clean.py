"""Documents without errors."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.yaml_text.library import Library


def require_clean(file: Path, library: Library, values: Mapping[str, str] | None = None) -> None:
    """Check a document on which a command relies.

    Args:
        file: File of the document.
        library: Library that finds documents by name.
        values: Values of programs' parameters.

    Raises:
        DiagnosticsError: The document has errors.
    """
    from cbdsl.checking.document import check_document
    from cbdsl.checking.session import Session
    from cbdsl.diagnostics.errors import DiagnosticsError

    diagnostics = check_document(file, session=Session(library, values))
    if any(diagnostic.is_error for diagnostic in diagnostics):
        raise DiagnosticsError(diagnostics)
