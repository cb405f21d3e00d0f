"""Files of tasks: the journal beside a document, and checks before the first item."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

from cbdsl.storage.journal import JournalError

# Smallest free space for the documents of a task, bytes.
_ROOM = 1 << 16


def trial_journal(path: Path) -> Path:
    """Return the journal of the trial whose policy is written to ``path``."""
    return path.with_suffix(".episodes.jsonl")


def exploration_journal(path: Path) -> Path:
    """Return the journal of the exploration whose catalog is written to ``path``."""
    return path.with_suffix(".actions.jsonl")


def require_room(folders: Iterable[Path]) -> None:
    """Create folders, and check that documents can be written to them.

    The check is made before the items, not after them.

    Raises:
        OSError: If a file cannot be written, or the disk is full.
    """
    for folder in folders:
        folder.mkdir(parents=True, exist_ok=True)
        # A full disk still creates empty files, so some bytes are written.
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(_ROOM))
            file.flush()


def require_free(journal: Path, files: Iterable[Path], origin: str, *, resume: bool) -> None:
    """Check that a task overwrites no file by accident.

    Args:
        journal: Journal of the task.
        files: Documents that the task may write.
        origin: Participle for the origin of the documents, such as ``learned``.
        resume: True to continue a task that was begun there.

    Raises:
        JournalError: If a file exists.
    """
    if journal.exists() and not resume:
        raise JournalError(
            f"{journal} is there already: go on with --resume, or choose another --out"
        )
    # A document beside its journal is an earlier outcome of the same task, which a resumed task may
    # replace.
    for file in files:
        if file.is_dir() or (file.exists() and not journal.exists()):
            raise JournalError(
                f"{file} is there already, and was not {origin} here: choose another"
            )
