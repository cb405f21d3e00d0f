"""Distinction of this project's documents from the YAML files of other tools."""

from __future__ import annotations

import re
from pathlib import Path

from cbdsl.documents.kinds import KINDS, kind_of, models

# A key at the top level: in the first column, or first in the text, which may be in braces.
_TOP = r"(?:^|\A(?:\s|#[^\n]*\n|---[^\n]*\n)*\{?\s*)[\"']?"
_VERSION = re.compile(_TOP + r"cbdsl[\"']?\s*:(?!\S)", re.MULTILINE)
_KIND = re.compile(_TOP + r"kind[\"']?\s*:\s+[\"']?(\w+)", re.MULTILINE)
# Every manifest of Kubernetes, which has kinds too, says which interface it is of.
_MANIFEST = re.compile(_TOP + r"apiVersion[\"']?\s*:(?!\S)", re.MULTILINE)


def is_declared(text: str) -> bool:
    """Return whether a text declares itself a document of this project.

    It does by the key ``cbdsl``, or by a known ``kind`` outside of a Kubernetes manifest. Neither
    the rest of the text nor its syntax has to be sound.
    """
    if _VERSION.search(text):
        return True
    kind = _KIND.search(text)
    return kind is not None and kind[1] in KINDS and not _MANIFEST.search(text)


def is_own(path: Path, text: str) -> bool:
    """Return whether a file is a document of this project, be it sound or not.

    Args:
        path: File of the text.
        text: Its text.

    Returns:
        True if the text declares it, or if the file is in a folder of documents, such as
        ``programs/stages``. Kubernetes manifests are no documents, wherever they are.
    """
    return is_declared(text) or (_is_filed(path) and not _MANIFEST.search(text))


def _is_filed(path: Path) -> bool:
    """Return whether a file is in a folder of documents of some kind."""
    folder = path.absolute().parent.parts
    folders = (Path(kind_of(model).folder).parts for model in models().values())
    return any(folder[-len(parts) :] == parts for parts in folders)
