"""Journals of lines: the completed steps, from which an interrupted command continues."""

from __future__ import annotations

import fcntl
import json
import os
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from shlex import quote
from types import TracebackType
from typing import Any, BinaryIO, Self

from cbdsl.diagnostics.errors import UsageError

# Time for which a process that lost its cluster may be busy with its last line, s.
_PATIENCE = 60.0


class JournalError(UsageError):
    """Error of an unusable journal; the message gives the reason and the remedy."""


class DamagedJournalError(JournalError):
    """Error of an unusable line of a journal; the message gives the line and the remedy."""


class LineJournal:
    """File of JSON lines: the identity of an undertaking, then each step when it is complete.

    An unfinished line of a killed process is ignored and overwritten. Two processes never write the
    same journal: the second waits a minute for the first to end.

    Args:
        path: Path of the file; the undertaking continues if the file exists.
        identity: All inputs of the steps, as JSON data.
        what: Name of the undertaking in messages.

    Attributes:
        path: Path of the file.
        rows: Steps read from the file.

    Raises:
        JournalError: If the file belongs to another undertaking, is no journal, or is being
            written.
        OSError: If the file cannot be read or written.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any], what: str = "trial") -> None:
        self._file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o644), "r+b", buffering=0)
        try:
            lock(self._file, path, _PATIENCE)
            self.path, self.rows = path, self._take_up(path, identity, what)
        except BaseException:
            self._file.close()
            raise

    def _take_up(self, path: Path, identity: Mapping[str, Any], what: str) -> list[dict[str, Any]]:
        rows, sound = rows_of(self._file.read(), path, what=what)
        if rows:
            require_same(path, rows[0], identity, what)
        self._file.truncate(sound)
        self._file.seek(sound)
        if not rows:
            self._begin(path, identity)
        return rows[1:]

    def _begin(self, path: Path, identity: Mapping[str, Any]) -> None:
        try:
            self.append_row(identity)
        except OSError:
            path.unlink()  # an empty journal would block the next attempt
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._file.close()

    def append_row(self, row: Mapping[str, Any]) -> None:
        """Append a line and flush it to disk.

        Raises:
            OSError: If the line cannot be written.
        """
        left = memoryview(json.dumps(row, ensure_ascii=False).encode() + b"\n")
        while left:  # a nearly full disk takes a part, and fails only at the next write
            left = left[self._file.write(left) :]
        os.fsync(self._file.fileno())


def rows_of(
    data: bytes, path: Path, first: int = 1, what: str = "trial"
) -> tuple[list[dict[str, Any]], int]:
    """Return the complete lines of a part of a journal, and the offset of their end.

    Args:
        data: Bytes from the beginning of a line; an unfinished last line is left out.
        path: Path of the journal, for messages.
        first: Number of the first line.
        what: Name of the undertaking, for messages.

    Raises:
        JournalError: If the data is no journal.
    """
    sound = data.rfind(b"\n") + 1
    lines = data[:sound].split(b"\n")[:-1]
    return [_row(line, path, number, what) for number, line in enumerate(lines, first)], sound


def _row(line: bytes, path: Path, number: int, what: str) -> dict[str, Any]:
    try:
        row = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise damaged(path, number, f"it is not JSON ({error})", what) from error
    if not isinstance(row, dict):
        raise damaged(path, number, "it is not a JSON object", what)
    return row


def damaged(path: Path, number: int, problem: str, what: str = "trial") -> JournalError:
    """Return the error of a line that cannot be used."""
    if number == 1:
        return DamagedJournalError(f"{path} is not a journal of a {what}: of line 1, {problem}")
    option = "" if what == "calibration" else ", with --resume where it has that"
    whole, aside = quote(str(path)), quote(f"{path}.damaged")
    return DamagedJournalError(
        f"{path}, line {number}: {problem}; the journal is damaged, and was left as it is. What "
        f"stands above is whole, and the same command goes on there{option}, after\n"
        f"  mv {whole} {aside} && head -n {number - 1} {aside} > {whole}"
    )


def require_same(
    path: Path, known: Mapping[str, Any], wanted: Mapping[str, Any], what: str = "trial"
) -> None:
    """Check that two identities are the same.

    Raises:
        JournalError: If they differ; the message lists the differences.
    """
    if differences := "; ".join(_differences(known, wanted)):
        raise JournalError(
            f"{path} belongs to another {what}: {differences}; "
            "ask for the same, or choose another --out"
        )


def _differences(known: Mapping[str, Any], wanted: Mapping[str, Any]) -> Iterator[str]:
    """Yield the differences between two identities, in words."""
    for key in {**known, **wanted}:
        old, new = known.get(key), wanted.get(key)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            if old.get("name") != new.get("name"):
                yield f"{key} was {old.get('name')}, is {new.get('name')}"
            elif "sha256" in old:
                yield f"{key} '{old.get('name')}' has changed since"
            else:
                yield from _differences(old, new)
        else:
            yield f"{key} was {_shown(old)}, is {_shown(new)}"


def _shown(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return str(value.get("name", value))
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def lock(file: BinaryIO, path: Path, patience: float) -> None:
    """Lock a file; the lock ends with the process, however that ends.

    Raises:
        JournalError: If another process holds the lock for longer than ``patience``, s.
        OSError: If the file system does not support locks.
    """
    deadline = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError as error:
            if time.monotonic() >= deadline:
                raise JournalError(
                    f"another process is at work on {path}: let it end first"
                ) from error
        time.sleep(0.1)
