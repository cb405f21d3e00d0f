"""Journal of a trial: one line per finished episode, from which it resumes."""

from __future__ import annotations

import fcntl
import json
import os
import time
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, NamedTuple, Self

from cbdsl.errors.errors import UsageError
from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition

# A process that lost its cluster may still be busy with its last episode, s.
_PATIENCE = 60.0


class JournalError(UsageError):
    """A journal cannot be used; the message says why and what to do."""


class JournalEntry(NamedTuple):
    """A line of a journal.

    Attributes:
        experience: the episode.
        wall_seconds: how long it took, s.
    """

    experience: Experience
    wall_seconds: float


class RowJournal:
    """File of JSON lines: the identity of a trial, then a row for each thing as soon as it is over.

    Where the file is there, the trial goes on.
    A line that a killed process left unfinished counts for nothing, and is overwritten.
    No two processes write the same journal: the second waits a minute for the first to end.

    Args:
        path: the file.
        identity: all that the rows depend on, as JSON has it.

    Attributes:
        path: the file.
        rows: those that the file held.

    Raises:
        JournalError: the file belongs to another trial, or is none, or is being written.
        OSError: it cannot be read or written.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any]) -> None:
        self._file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o644), "r+b", buffering=0)
        try:
            _lock(self._file, path, _PATIENCE)
            self.path, self.rows = path, self._take_up(path, identity)
        except BaseException:
            self._file.close()
            raise

    def _take_up(self, path: Path, identity: Mapping[str, Any]) -> list[dict[str, Any]]:
        rows, sound = rows_of(self._file.read(), path)
        if rows:
            _require_same(path, rows[0], identity)
        self._file.truncate(sound)
        self._file.seek(sound)
        if not rows:
            self._begin(path, identity)
        return rows[1:]

    def _begin(self, path: Path, identity: Mapping[str, Any]) -> None:
        try:
            self.append_row(identity)
        except OSError:
            path.unlink()  # a journal that holds nothing would only be in the way
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
        """Append a row and flush it to disk.

        Raises:
            OSError: it cannot be written.
        """
        left = memoryview(json.dumps(row, ensure_ascii=False).encode() + b"\n")
        while left:  # a disk that is nearly full takes a part, and says so only of the next
            left = left[self._file.write(left) :]
        os.fsync(self._file.fileno())


class Journal(RowJournal):
    """Journal of episodes; see ``RowJournal``.

    Attributes:
        finished: the episodes that the file holds.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any]) -> None:
        super().__init__(path, identity)
        try:
            entries = (entry_of(row, path, line) for line, row in enumerate(self.rows, 2))
            self.finished = tuple(entry.experience for entry in entries)
        except BaseException:
            self._file.close()
            raise

    def append(self, experience: Experience, wall_seconds: float) -> None:
        """Append a finished episode and flush it to disk.

        Args:
            experience: the episode.
            wall_seconds: how long it took; for people.

        Raises:
            OSError: it cannot be written.
        """
        self.append_row({**asdict(experience), "wall_seconds": round(wall_seconds, 3)})


def rows_of(data: bytes, path: Path, first: int = 1) -> tuple[list[dict[str, Any]], int]:
    """Complete lines in a part of a journal, and where they end.

    Args:
        data: from the beginning of a line; what follows the last end of a line is left out.
        path: of the journal, for messages.
        first: the number of its first line.

    Raises:
        JournalError: it is no journal.
    """
    sound = data.rfind(b"\n") + 1
    lines = data[:sound].split(b"\n")[:-1]
    return [_row(line, path, number) for number, line in enumerate(lines, first)], sound


def _row(line: bytes, path: Path, number: int) -> dict[str, Any]:
    try:
        row = json.loads(line)
    except ValueError as error:
        raise _damaged(path, number, f"it is no JSON ({error})") from error
    if not isinstance(row, dict):
        raise _damaged(path, number, "it is no JSON object")
    return row


def _damaged(path: Path, number: int, problem: str) -> JournalError:
    if number == 1:
        return JournalError(f"{path} is no journal of a trial: of line 1, {problem}")
    return JournalError(
        f"{path}, line {number}: {problem}; the journal is damaged. What stands above is whole: "
        f"delete this line and those below, and --resume goes on there"
    )


def entry_of(row: Mapping[str, Any], path: Path, line: int) -> JournalEntry:
    """Episode in a line of a journal.

    Args:
        row: the line.
        path: of the journal, for messages.
        line: its number.

    Raises:
        JournalError: there is none.
    """
    try:
        return _entry(row)
    except KeyError as error:
        raise _damaged(path, line, f"it lacks {error}") from error
    except (TypeError, ValueError, AttributeError) as error:
        raise _damaged(path, line, f"it is no episode ({error})") from error


def require_usable(path: Path, identity: Mapping[str, Any]) -> None:
    """Check that the trial in a journal can be resumed.

    Args:
        path: the journal, which is there.
        identity: what of the trial is known; what it does not name is not compared.

    Raises:
        JournalError: it cannot; the message says why.
        OSError: the file cannot be read or written.
    """
    with path.open("r+b", buffering=0) as file:
        _lock(file, path, patience=0.0)
        rows, _ = rows_of(file.read(), path)
    if rows:
        known = {key: value for key, value in rows[0].items() if key in identity}
        _require_same(path, known, identity)


def _require_same(path: Path, known: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    if differences := "; ".join(_differences(known, wanted)):
        raise JournalError(
            f"{path} belongs to another trial: {differences}; "
            "ask for the same, or choose another --out"
        )


def _differences(known: Mapping[str, Any], wanted: Mapping[str, Any]) -> list[str]:
    """Differences between two identities, in words."""
    differences = []
    for key in {**known, **wanted}:
        old, new = known.get(key), wanted.get(key)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            if old.get("name") != new.get("name"):
                differences.append(f"{key} was {old.get('name')}, is {new.get('name')}")
            elif "sha256" in old:
                differences.append(f"{key} '{old.get('name')}' has changed since")
            else:
                differences += _differences(old, new)
        else:
            differences.append(f"{key} was {_shown(old)}, is {_shown(new)}")
    return differences


def _shown(value: object) -> str:
    if value is None:
        return "nothing"
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def _lock(file: BinaryIO, path: Path, patience: float) -> None:
    """Lock a file; the lock ends with the process, however that ends.

    Raises:
        JournalError: somebody else is, and does not end within ``patience``, s.
        OSError: the file system knows no locks.
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


def _entry(row: Mapping[str, Any]) -> JournalEntry:
    transitions = (
        Transition(**{**each, "rewarding": tuple(each["rewarding"])}) for each in row["transitions"]
    )
    experience = Experience(
        context=row["context"],
        seed=row["seed"],
        transitions=tuple(transitions),
        rewarded={effector: tuple(angles) for effector, angles in row["rewarded"].items()},
        ticks=row["ticks"],
        sim_seconds=row["sim_seconds"],
    )
    return JournalEntry(experience, row["wall_seconds"])
