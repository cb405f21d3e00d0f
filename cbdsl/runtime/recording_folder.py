"""Folder of recordings: nothing in it is written over unasked, nor by two processes at once."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from cbdsl.errors.errors import UsageError


class RecordingFolder:
    """Place of the two files of each recorded episode.

    Args:
        path: the folder; made when it is made ready.
        overwrite: whether recordings that are there may be replaced.
    """

    def __init__(self, path: Path, *, overwrite: bool = False) -> None:
        self.path, self._overwrite = path, overwrite

    def files(self, seed: int) -> tuple[Path, Path]:
        """NPZ and JSON file of the episode with a seed."""
        stem = self.path / f"episode_{seed}"
        return stem.with_suffix(".npz"), stem.with_suffix(".json")

    def require_ready(self, seeds: Iterable[int]) -> None:
        """Make the folder, and check before the episodes that they can be kept.

        Raises:
            UsageError: it holds a recording of one of them.
            OSError: it cannot be made or written.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=self.path):
            pass
        for seed in seeds:
            self._require_absent(seed)

    @contextmanager
    def claim(self, seed: int) -> Iterator[None]:
        """Keep other processes from recording the same episode here meanwhile.

        Raises:
            UsageError: one does, or did by now.
            OSError: the folder cannot be written, or its file system knows no locks.
        """
        name = self.path / f".episode_{seed}.lock"
        with name.open("wb") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise UsageError(
                    f"{self.path}: another process is recording the episode with seed {seed} here; "
                    "choose another folder"
                ) from error
            try:
                self._require_absent(seed)
                yield
            finally:
                name.unlink(missing_ok=True)

    def _require_absent(self, seed: int) -> None:
        there = next((file for file in self.files(seed) if os.path.lexists(file)), None)
        if there is not None and not self._overwrite:
            raise UsageError(
                f"{there}: there is a recording already; choose another folder, or replace it "
                "with --overwrite"
            )


def replace_file(path: Path, fill: Callable[[BinaryIO], object]) -> None:
    """Write a file so that nobody ever sees half of it.

    Args:
        path: of the file.
        fill: writes its contents.

    Raises:
        OSError: it cannot be written; it names the file.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            fill(file)
        os.replace(partial, path)
    except BaseException as error:
        partial.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise
