"""Rows of JSON in a file, each stored immediately."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any


class KeptRows:
    """Rows in a file, a line for each.

    Args:
        path: File of the rows; it need not exist.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def __iter__(self) -> Iterator[Any]:
        """Yield the rows in order, without rows truncated by the end of a process."""
        for line in self._text().splitlines():
            try:
                yield json.loads(line)
            except ValueError:
                continue

    def add(self, row: Any) -> None:
        """Append a row on a separate line."""
        text = self._text()
        # A killed process may leave an unfinished line, which must not join the new row.
        start = "\n" if text and not text.endswith("\n") else ""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(f"{start}{json.dumps(row)}\n")

    def _text(self) -> str:
        return self._path.read_text(encoding="utf-8") if self._path.exists() else ""
