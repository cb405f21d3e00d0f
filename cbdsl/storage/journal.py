"""Journal: the finished items of an undertaking, from which an interrupted command continues."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from shlex import quote
from types import TracebackType
from typing import Any, BinaryIO, Generic, Self, TypeVar

from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.legible_text import encoded
from cbdsl.storage.contents import KINDS, json_of
from cbdsl.storage.file_lock import LockedError, lock


def differences(known: Mapping[str, Any], requested: Mapping[str, Any]) -> Iterator[str]:
    """Yield the differences between two identities, in words."""
    for key in {**known, **requested}:
        old, new = known.get(key), requested.get(key)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            # Documents are identified by name and digest. Another name is another document, and
            # another digest the same document with changed contents.
            if old.get("name") != new.get("name"):
                yield f"{key} was {old.get('name')}, is {new.get('name')}"
            elif "sha256" in old:
                yield f"{key} '{old.get('name')}' has changed since"
            else:
                yield from differences(old, new)
        else:
            yield f"{key} was {_shown(old)}, is {_shown(new)}"


def _shown(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return str(value.get("name", value))
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


Row = TypeVar("Row")

# Time for which a process that lost its cluster may be busy with its last line, s.
_PATIENCE = 60.0
#: Largest journal, bytes: a hundred thousand episodes.
MOST_BYTES = 1 << 30


class JournalError(UsageError):
    """Error of an unusable journal; the message gives the reason and the remedy."""


class DamagedJournalError(JournalError):
    """Error of an unusable line of a journal; the message gives the line and the remedy."""


@dataclass(frozen=True)
class RowForm(Generic[Row]):
    """Form of the rows of one kind of journal.

    Attributes:
        undertaking: Noun of the undertaking, such as ``trial``.
        item: Noun of an item with its article, such as ``an episode``.
        read: Function that converts JSON data to a row; it raises ``KeyError``, ``TypeError``,
            ``ValueError`` or ``AttributeError`` for other data.
        write: Function that converts a row to JSON data.
    """

    undertaking: str
    item: str
    read: Callable[[Mapping[str, Any]], Row]
    write: Callable[[Row], Mapping[str, Any]]

    def parse(self, data: Mapping[str, Any], path: Path, line: int) -> Row:
        """Return the row in a line of a journal.

        Raises:
            DamagedJournalError: If the line holds another item.
        """
        try:
            return self.read(data)
        except KeyError as error:
            raise damaged(path, line, f"it lacks {error}", self.undertaking) from error
        except (TypeError, ValueError, AttributeError) as error:
            problem = f"it is not {self.item} ({error})"
            raise damaged(path, line, problem, self.undertaking) from error


class Journal(Generic[Row]):
    """File of JSON lines: the identity of an undertaking, then each item when it is finished.

    An unfinished line of a killed process is ignored and overwritten. Two processes never write the
    same journal: the second waits a minute for the first to end.

    Args:
        path: Path of the file; the undertaking continues if the file exists.
        identity: All inputs of the items, as JSON data.
        form: Form of the rows.
        varying: True if an identity in the file may differ; the caller compares it.

    Attributes:
        path: Path of the file.
        identity: Identity in the file.
        rows: Items in the file; the first is in line 2.

    Raises:
        JournalError: If the file belongs to another undertaking, is no journal, or is being
            written.
        OSError: If the file cannot be read or written.
    """

    def __init__(
        self, path: Path, identity: Mapping[str, Any], form: RowForm[Row], *, varying: bool = False
    ) -> None:
        self.path, self._form = path, form
        # The file is opened without truncation, because it may only be changed under its lock.
        self._file = opened(path, os.O_RDWR | os.O_CREAT)
        try:
            _claim(self._file, path, _PATIENCE)
            known, self._sound = rows_of(data_of(self._file, path), path, form.undertaking)
            if known and not varying:
                require_same(path, known[0], identity, form.undertaking)
            self.identity = known[0] if known else identity
            self.rows = [form.parse(row, path, line) for line, row in enumerate(known[1:], 2)]
            self._continue(is_new=not known)
        except BaseException:
            self._file.close()
            raise

    def _continue(self, *, is_new: bool) -> None:
        """Remove an unfinished line, and begin a new file with its identity."""
        self._file.truncate(self._sound)
        self._file.seek(self._sound)
        if is_new:
            try:
                self._append_line(self.identity)
            except OSError:
                self.path.unlink()  # an empty journal would block the next attempt
                raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, and let other processes write it."""
        self._file.close()

    def append(self, row: Row) -> None:
        """Append an item and flush it to disk.

        Raises:
            OSError: If the item cannot be written.
        """
        self._append_line(self._form.write(row))
        self.rows.append(row)

    def _append_line(self, data: Mapping[str, Any]) -> None:
        left = memoryview(encoded(json.dumps(data, ensure_ascii=False)) + b"\n")
        while left:  # a nearly full disk takes a part, and fails only at the next write
            left = left[self._file.write(left) :]
        os.fsync(self._file.fileno())


def opened(path: Path, flags: int = os.O_RDWR) -> FileIO:
    """Open a journal, whose name is derived from that of a document and may be anything.

    A link, a pipe and a device are neither followed nor waited for.

    Raises:
        JournalError: If the path is not that of a regular file.
        OSError: If the file cannot be opened.
    """
    with suppress(FileNotFoundError):
        kind = stat.S_IFMT(path.lstat().st_mode)
        if kind != stat.S_IFREG:
            raise JournalError(
                f"{path} is {KINDS.get(kind, 'a link')}, no journal; remove it, or choose another "
                "--out"
            )
    handle = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644)
    return FileIO(handle, "r+b" if flags & os.O_RDWR else "rb")


def data_of(file: FileIO, path: Path) -> bytes:
    """Return the contents of a journal, from the current place to the end.

    Raises:
        JournalError: If they are larger than those of any journal.
    """
    size = os.fstat(file.fileno()).st_size - file.tell()
    # A sparse file of any size begins with a zero, a journal with a brace.
    if size > MOST_BYTES or (size and os.pread(file.fileno(), 1, 0) != b"{"):
        raise JournalError(f"{path} is no journal; remove it, or choose another --out")
    return file.read()


def _claim(file: BinaryIO, path: Path, patience: float) -> None:
    try:
        lock(file, patience)
    except LockedError as error:
        raise JournalError(f"another process is at work on {path}: let it end first") from error


def rows_of(
    data: bytes, path: Path, undertaking: str = "trial", first: int = 1
) -> tuple[list[dict[str, Any]], int]:
    """Return the complete lines of a part of a journal, and the offset of their end.

    Args:
        data: Bytes from the beginning of a line; an unfinished last line is left out.
        path: Path of the journal, for messages.
        undertaking: Noun of the undertaking, for messages.
        first: Number of the first line.

    Raises:
        DamagedJournalError: If the data is no journal.
    """
    # A line is complete with its line feed. JSON escapes line feeds within texts, so that each row
    # is one line.
    sound = data.rfind(b"\n") + 1
    lines = data[:sound].split(b"\n")[:-1]
    return [_object(line, path, n, undertaking) for n, line in enumerate(lines, first)], sound


def _object(line: bytes, path: Path, number: int, undertaking: str) -> dict[str, Any]:
    try:
        row = json_of(line)
    except (ValueError, RecursionError) as error:
        raise damaged(path, number, f"it is not JSON ({error})", undertaking) from error
    if not isinstance(row, dict):
        raise damaged(path, number, "it is not a JSON object", undertaking)
    return row


def damaged(
    path: Path, number: int, problem: str, undertaking: str = "trial"
) -> DamagedJournalError:
    """Return the error of a line that cannot be used."""
    if number == 1:
        return DamagedJournalError(
            f"{path} is not a journal of a {undertaking}: of line 1, {problem}"
        )
    option = "" if undertaking == "calibration" else ", with --resume where it has that"
    whole, aside = quote(str(path)), quote(f"{path}.damaged")
    return DamagedJournalError(
        f"{path}, line {number}: {problem}; the journal is damaged, and was left unchanged. The "
        f"lines above are whole, and the same command goes on there{option}, after: "
        f"mv {whole} {aside} && head -n {number - 1} {aside} > {whole}"
    )


def require_same(
    path: Path, known: Mapping[str, Any], requested: Mapping[str, Any], undertaking: str = "trial"
) -> None:
    """Check that two identities are the same.

    Raises:
        JournalError: If they differ; the message lists the differences.
    """
    if different := "; ".join(differences(known, requested)):
        raise JournalError(
            f"{path} belongs to another {undertaking}: {different}; "
            "ask for the same, or choose another --out"
        )


def require_usable(path: Path, identity: Mapping[str, Any]) -> None:
    """Check that the undertaking in a journal can be resumed.

    Args:
        path: Path of the journal, which exists.
        identity: Known parts of the undertaking's identity; other parts are not compared.

    Raises:
        JournalError: If it cannot be resumed; the message gives the reason.
        OSError: If the file cannot be read or written.
    """
    with opened(path) as file:
        _claim(file, path, patience=0.0)
        rows, _ = rows_of(data_of(file, path), path)
    if rows:
        # The first row is the identity; only its parts that are known before the task can be
        # compared.
        known = {key: value for key, value in rows[0].items() if key in identity}
        require_same(path, known, identity)
