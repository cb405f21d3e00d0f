"""Addresses of an editor's documents, saved or not, as files."""

from __future__ import annotations

import re
from itertools import count
from pathlib import Path

from pygls.uris import from_fs_path, to_fs_path, urlparse


class Addresses:
    """Files that stand for the documents of an editor.

    Documents that were never saved have no file, and neither do old versions of saved documents, or
    addresses that no file can have. A path in the folder of the editor stands for such a document,
    and its references are resolved from there.

    Args:
        here: Folder of the editor.
    """

    def __init__(self, here: Path) -> None:
        self._here = here
        self._paths: dict[str, Path] = {}
        self._uris: dict[Path, str] = {}

    def path(self, uri: str) -> Path:
        """Return the file of a document; equal addresses have equal files."""
        if uri not in self._paths:
            file = to_fs_path(uri)
            is_possible = file is not None and "\0" not in file
            path = Path(file) if file and is_possible else self._stand_in(uri)
            self._paths[uri] = path
            # Editors may spell one file in several ways, as `c:` and `c%3A`. Answers use the first
            # one.
            self._uris.setdefault(path, uri)
        return self._paths[uri]

    def uri(self, path: Path) -> str:
        """Return the address of a file, as the editor wrote it, or an absolute one."""
        absolute = path.absolute()
        return self._uris.get(absolute) or from_fs_path(str(absolute)) or absolute.as_uri()

    def _stand_in(self, uri: str) -> Path:
        name = re.sub(r"[^\w.-]", "_", Path(urlparse(uri)[2]).name).strip(".") or "unsaved"
        # Two unsaved documents of one name get different files: `Untitled-1` and `1_Untitled-1`.
        names = (name if number == 0 else f"{number}_{name}" for number in count())
        paths = (self._here / each for each in names)
        return next(path for path in paths if path not in self._uris and not path.exists())
