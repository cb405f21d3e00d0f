"""Damage to the files of a folder of trials."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

#: Ending of the journals of learning, whose reader reports damage itself.
_JOURNALS = ".episodes.jsonl"


class DamagedLine(NamedTuple):
    """Line of a file that holds no row.

    Attributes:
        path: Path of the file.
        number: Line number, from 1.
        problem: Reason why the line holds no row.
        passed: True if the line is skipped, such as an unfinished line of a killed process.
    """

    path: Path
    number: int
    problem: str
    passed: bool

    def format_message(self) -> str:
        """Return a sentence with the place and the remedy."""
        cure = "it is passed over, and what it held is run again"
        if not self.passed:
            cure = "nothing was changed; delete this line, and the same command runs it again"
        return f"{self.path}, line {self.number}: {self.problem}; {cure}"


def damaged_lines(folder: Path) -> Iterator[DamagedLine]:
    """Return the lines without a row, of all files of rows below a folder.

    Raises:
        OSError: A file cannot be read.
    """
    for path in sorted(folder.rglob("*.jsonl")):
        if path.name.endswith(_JOURNALS):
            continue
        for number, line in enumerate(path.read_bytes().splitlines(), 1):
            yield from _damage(path, number, line)


def _damage(path: Path, number: int, line: bytes) -> Iterator[DamagedLine]:
    try:
        row = json.loads(line.decode("utf-8"))
    except UnicodeDecodeError:
        yield DamagedLine(path, number, "it is not UTF-8", passed=False)
    except (ValueError, RecursionError):
        yield DamagedLine(path, number, "it is not JSON", passed=True)
    else:
        if not isinstance(row, (dict, list)):
            yield DamagedLine(path, number, "it is not a row of a trial", passed=False)
