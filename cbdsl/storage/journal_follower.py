"""Journal follower: the new rows of a journal that another process writes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Generic

from cbdsl.storage.journal import Row, RowForm, data_of, opened, rows_of


class JournalFollower(Generic[Row]):
    """Reader of new lines in a journal.

    Args:
        path: Path of the journal, which need not exist yet.
        form: Form of its rows.

    Attributes:
        identity: Identity of the undertaking; empty until its journal is begun.
    """

    def __init__(self, path: Path, form: RowForm[Row]) -> None:
        self._path, self._form = path, form
        self._offset = self._lines = 0
        self.identity: dict[str, Any] = {}

    def poll(self) -> list[Row]:
        """Return the items that were finished since the last poll, or since the beginning.

        Raises:
            JournalError: If the file is no journal.
            OSError: If it cannot be read.
        """
        try:
            with opened(self._path, os.O_RDONLY) as file:
                file.seek(self._offset)
                data = data_of(file, self._path)
        except FileNotFoundError:
            return []
        rows, length = rows_of(data, self._path, self._form.undertaking, self._lines + 1)
        # An unfinished line does not count, and is read again by the next poll.
        self._offset += length
        numbered = list(enumerate(rows, self._lines + 1))
        self._lines += len(rows)
        if numbered and not self.identity:
            self.identity = numbered.pop(0)[1]
        return [self._form.parse(row, self._path, line) for line, row in numbered]
