"""Journal follower: progress of a trial that runs in another process."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cbdsl.runtime.line_journal import rows_of
from cbdsl.training.journal import JournalEntry, entry_of


class JournalFollower:
    """Reader of new lines in the journal of a trial.

    Args:
        path: Path of the journal, which need not exist yet.

    Attributes:
        identity: Identity of the trial; empty until its journal is begun.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._read, self._lines = path, 0, 0
        self.identity: dict[str, Any] = {}

    def poll(self) -> list[JournalEntry]:
        """Return the episodes that ended since the last poll, or since the trial began.

        Raises:
            JournalError: If the file is no journal.
            OSError: If it cannot be read.
        """
        try:
            with self._path.open("rb") as file:
                file.seek(self._read)
                rows, length = rows_of(file.read(), self._path, self._lines + 1)
        except FileNotFoundError:
            return []
        self._read += length
        numbered = list(enumerate(rows, self._lines + 1))
        self._lines += len(rows)
        if numbered and not self.identity:
            self.identity = numbered.pop(0)[1]
        return [entry_of(row, self._path, line) for line, row in numbered]
