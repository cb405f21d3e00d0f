"""``cbdsl.check``: diagnostics in documents."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.diagnostics.diagnostic import Diagnostic


def check(*documents: str | Path, values: Mapping[str, str] | None = None) -> list[Diagnostic]:
    """Return all diagnostics in documents and in the documents they refer to; causes come first.

    Args:
        documents: Files or names, as for ``cb validate``.
        values: Values of programs' parameters, by name.

    Returns:
        Diagnostics, each once; empty if there are none. ``is_error`` separates errors from
        warnings.

    Raises:
        UsageError: No document has such a name.
    """
    from cbdsl.checking.safety_net import check_safely
    from cbdsl.checking.session import Session
    from cbdsl.yaml_text.library import Library

    library = Library()
    session = Session(library, dict(values or {}))
    files = [file for word in documents for file in library.locate_any(str(word))]
    # The diagnostics of a robot come with each of its programs. A dictionary keeps the first, in
    # order.
    diagnostics: dict[Diagnostic, None] = {}
    for file in files:
        diagnostics.update(dict.fromkeys(check_safely(file, session)))
    return list(diagnostics)
