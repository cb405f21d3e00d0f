"""Distinction of this project's documents from the YAML files of other tools."""

from __future__ import annotations

import re
from pathlib import Path

from cbdsl.documents.kinds import KINDS, kind_of, models

# Blank lines, comments and a document's mark before the root, which may be in braces.
_BEFORE = re.compile(r"(?:\s|#[^\n]*(?:\n|\Z)|---[ \t]*\n)*(\{)?")


def declared_kind(text: str) -> str | None:
    """Return the value of a text's key ``kind``, known or not, or ``None`` without one."""
    return _top(text, "kind")


def is_declared(text: str) -> bool:
    """Return whether a text declares itself a document of this project.

    The key ``cbdsl`` declares it, as does a known ``kind`` outside of a Kubernetes manifest. Other
    parts of the text, and its syntax, may be invalid.
    """
    if _top(text, "cbdsl") is not None:
        return True
    kind = declared_kind(text)
    return kind is not None and kind in KINDS and not _is_manifest(text)


def is_own(path: Path, text: str) -> bool:
    """Return whether a file is a document of this project, with or without errors.

    Args:
        path: File of the text.
        text: Text of the file.

    Returns:
        True if the text declares it, or if the file is in a folder of documents, such as
        ``programs/stages``. Kubernetes manifests are never documents.
    """
    return is_declared(text) or (_is_filed(path) and not _is_manifest(text))


def _is_manifest(text: str) -> bool:
    """Return whether a text is a manifest of Kubernetes, which has kinds too."""
    return _top(text, "apiVersion") is not None


def _top(text: str, key: str) -> str | None:
    """Return the first word of the value of a key at the top level, or ``None`` without it.

    Keys at the top level are recognised by lines and braces, since the text may not be valid YAML.
    """
    root = _BEFORE.match(text)
    assert root is not None, "it matches nothing, too"
    value = rf"[\"']?{key}[\"']?\s*:(?=\s|\Z|[\"'])[ \t]*[\"']?([\w.-]*)"
    # The root is in braces, as in ``{cbdsl: 1, kind: robot}``: keys follow a brace or a comma.
    if root[1] is not None:
        match = re.compile(rf"[{{,]\s*{value}").search(text, root.start(1))
    else:
        # The first key may be indented. Any further key is at the top level only at the start of a
        # line.
        at_start = re.compile(value).match(text, root.end())
        match = at_start or re.compile(rf"^{value}", re.MULTILINE).search(text)
    return None if match is None else match[1]


def _is_filed(path: Path) -> bool:
    """Return whether a file is in a folder of documents of some kind."""
    folder = path.absolute().parent.parts
    folders = (Path(kind_of(model).folder).parts for model in models().values())
    return any(folder[-len(parts) :] == parts for parts in folders)
