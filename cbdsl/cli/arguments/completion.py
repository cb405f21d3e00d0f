"""Names that a shell completes: documents of a kind, and codes of diagnostics."""

from __future__ import annotations

from collections.abc import Callable


def names_of(kind: str) -> Callable[[str], list[str]]:
    """Return the completion of names of documents, found as commands find them.

    Args:
        kind: Kind of document, such as ``program``.
    """

    def complete(incomplete: str) -> list[str]:
        from cbdsl.documents.kinds import KINDS
        from cbdsl.yaml_text.library import Library

        names = Library().names(KINDS.get(kind).model)
        return [name for name in names if name.startswith(incomplete)]

    return complete


def codes(incomplete: str) -> list[str]:
    """Return the codes of diagnostics that begin with a text."""
    from cbdsl.documents.kinds import entries

    return [code for code in sorted(entries()) if code.startswith(incomplete.upper())]
