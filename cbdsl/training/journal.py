"""Journal of a trial: one line per finished episode, from which it resumes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition
from cbdsl.runtime.line_journal import (
    JournalError,
    LineJournal,
    damaged,
    lock,
    require_same,
    rows_of,
)


class JournalEntry(NamedTuple):
    """A line of a journal.

    Attributes:
        experience: the episode.
        wall_seconds: how long it took, s.
    """

    experience: Experience
    wall_seconds: float


class Journal(LineJournal):
    """File of JSON lines: the identity of a trial, then each episode as soon as it ends.

    Args:
        path: the file; where it is there, the trial goes on.
        identity: all that the episodes depend on, as JSON has it.

    Attributes:
        finished: the episodes that the file holds.

    Raises:
        JournalError: the file belongs to another trial, or is none, or is being written.
        OSError: it cannot be read or written.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any]) -> None:
        super().__init__(path, identity)
        try:
            entries = [entry_of(row, path, line) for line, row in enumerate(self.rows, 2)]
        except JournalError:
            self._file.close()
            raise
        self.finished = tuple(entry.experience for entry in entries)

    def append(self, experience: Experience, wall_seconds: float) -> None:
        """Append a finished episode and flush it to disk.

        Args:
            experience: the episode.
            wall_seconds: how long it took; for people.

        Raises:
            OSError: it cannot be written.
        """
        self.append_row({**asdict(experience), "wall_seconds": round(wall_seconds, 3)})


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
        raise damaged(path, line, f"it lacks {error}") from error
    except (TypeError, ValueError, AttributeError) as error:
        raise damaged(path, line, f"it is no episode ({error})") from error


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
        lock(file, path, patience=0.0)
        rows, _ = rows_of(file.read(), path)
    if rows:
        known = {key: value for key, value in rows[0].items() if key in identity}
        require_same(path, known, identity)


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
