"""Documents below a folder, without the YAML files of other tools."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from cbdsl.documents.ownership import is_own
from cbdsl.yaml_text.git_ignore import GitIgnore

_ENDINGS = (".yaml", ".yml")
# Folders of packages of other authors, and of compiled code.
_VENDORED = frozenset(
    {"node_modules", "bower_components", "vendor", "third_party", "site-packages", "__pycache__"}
)
# Folders of the kernel: they change while they are read, and hold no documents.
_SYSTEM = frozenset({"/proc", "/sys", "/dev"})
# Files that mark a virtual environment, a cache, and a colcon build folder.
_MARKS = ("pyvenv.cfg", "CACHEDIR.TAG", "COLCON_IGNORE")
# The keys that declare a document are within these bytes, which spares reading large data.
_HEAD = 256 * 1024


class DocumentFolder(NamedTuple):
    """Documents below a folder.

    Attributes:
        documents: Files of this project's documents, sorted.
        others: Number of YAML files of other tools.
        unreadable: Number of folders that cannot be read.
    """

    documents: tuple[Path, ...]
    others: int = 0
    unreadable: int = 0


def documents_below(folder: Path) -> DocumentFolder:
    """Find the documents below a folder.

    Folders that are hidden, vendored, built or ignored by git are skipped, unless the folder itself
    is one of them. Links to folders are not followed. A file that cannot be read is taken for a
    document, whose reader reports it.

    Args:
        folder: Folder to search.
    """
    faults: list[OSError] = []
    documents, others = [], 0
    for file in _yaml_files(folder, faults):
        text = _head(file)
        if text is None or is_own(file, text):
            documents.append(file)
        else:
            others += 1
    return DocumentFolder(tuple(sorted(documents)), others, len(faults))


def _yaml_files(folder: Path, faults: list[OSError]) -> Iterator[Path]:
    """Yield the YAML files below a folder that are not skipped, and note unreadable folders."""
    root = Path(os.path.abspath(folder))
    rules = {root: GitIgnore.above(root)}
    for name, folders, files in os.walk(folder, onerror=faults.append):
        here = root / Path(name).relative_to(folder)
        # A folder is visited once, and after its parent, which has left its rules here.
        ignored = rules.pop(here).with_folder(here)
        # The assignment in place keeps the walk out of the other folders.
        folders[:] = [
            each
            for each in folders
            if not _is_skipped(here / each) and not ignored.ignores(here / each, is_folder=True)
        ]
        rules.update({here / each: ignored for each in folders})
        for file in files:
            if file.endswith(_ENDINGS) and not ignored.ignores(here / file, is_folder=False):
                yield Path(name, file)


def _is_skipped(folder: Path) -> bool:
    """Return whether a folder is hidden, vendored, built, or the kernel's."""
    if folder.name.startswith(".") or folder.name in _VENDORED or str(folder) in _SYSTEM:
        return True
    return any(os.path.isfile(folder / mark) for mark in _MARKS)


def _head(file: Path) -> str | None:
    """Return the beginning of a regular file's text, or ``None`` if it cannot be read."""
    try:
        # Opening a named pipe would wait for its writer.
        if not stat.S_ISREG(file.stat().st_mode):
            return None
        with file.open("rb") as stream:
            data = stream.read(_HEAD)
    except OSError:
        return None
    is_wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    return data.decode("utf-16" if is_wide else "utf-8-sig", "replace")
