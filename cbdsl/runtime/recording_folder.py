"""Folder of recordings, protected from accidental overwriting and from concurrent processes."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from cbdsl.diagnostics.errors import UsageError
from cbdsl.storage.atomic_file import require_unlinked
from cbdsl.storage.file_lock import LockedError, lock


class RecordingFolder:
    """Place of the two files of each recorded episode.

    Args:
        path: Path of the folder; ``require_ready`` creates it.
        overwrite: True if existing recordings may be replaced.
    """

    def __init__(self, path: Path, *, overwrite: bool = False) -> None:
        self.path, self._overwrite = path, overwrite

    def files(self, seed: int) -> tuple[Path, Path]:
        """Return the NPZ and the JSON file of the episode with a seed."""
        stem = self.path / f"episode_{seed}"
        return stem.with_suffix(".npz"), stem.with_suffix(".json")

    def require_ready(self, seeds: Iterable[int]) -> None:
        """Create the folder, and check before the episodes that they can be recorded.

        Raises:
            UsageError: If it holds a recording of one of them.
            OSError: If it cannot be created or written, or a link is in the place of a recording.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        # Only an attempt shows whether the folder can be written to; its mode does not show a
        # read-only file system.
        with tempfile.TemporaryFile(dir=self.path):
            pass
        for seed in seeds:
            self._require_absent(seed)
            for file in (*self.files(seed), self.path / f".episode_{seed}.lock"):
                require_unlinked(file)

    @contextmanager
    def claim(self, seed: int) -> Iterator[None]:
        """Keep other processes from recording the same episode here meanwhile.

        Raises:
            UsageError: If another process records the episode, or has recorded it.
            OSError: If the folder cannot be written, or its file system does not support locks.
        """
        name = self.path / f".episode_{seed}.lock"
        with self._locked(name, seed):
            try:
                self._require_absent(seed)
                yield
            finally:
                name.unlink(missing_ok=True)

    def _locked(self, name: Path, seed: int) -> BinaryIO:
        """Return the open and locked file of a name."""
        while True:
            # Neither a link nor a pipe that another author left there is followed or waited for.
            flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK
            file = os.fdopen(os.open(name, flags, 0o666), "wb")
            try:
                lock(file)
                # Another process may have removed the file after it was opened here. Then its lock
                # protects nothing, because the name is free or that of a third process's file.
                if _is_file_of(name, file):
                    return file
            except LockedError as error:
                file.close()
                raise UsageError(
                    f"{self.path}: another process is recording the episode with seed {seed} here; "
                    "choose another folder"
                ) from error
            except BaseException:
                file.close()
                raise
            file.close()

    def _require_absent(self, seed: int) -> None:
        there = next((file for file in self.files(seed) if os.path.lexists(file)), None)
        if there is not None and not self._overwrite:
            raise UsageError(
                f"{there}: there is a recording already; choose another folder, or replace it "
                "with --overwrite"
            )


def _is_file_of(name: Path, file: BinaryIO) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), name.stat())
    except FileNotFoundError:
        return False
