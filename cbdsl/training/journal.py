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
    """Line of a journal.

    Attributes:
        experience: Experience of the episode.
        wall_seconds: Wall time of the episode, s.
    """

    experience: Experience
    wall_seconds: float


class Journal(LineJournal):
    """File of JSON lines: the identity of a trial, then each episode when it ends.

    Args:
        path: Path of the file; the trial continues if the file exists.
        identity: All inputs of the episodes, as JSON data.

    Attributes:
        finished: Experiences of the episodes in the file.

    Raises:
        JournalError: If the file belongs to another trial, is no journal, or is being written.
        OSError: If the file cannot be read or written.
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
            experience: Experience of the episode.
            wall_seconds: Wall time of the episode, s; for display only.

        Raises:
            OSError: If the episode cannot be written.
        """
        self.append_row({**asdict(experience), "wall_seconds": round(wall_seconds, 3)})


def entry_of(row: Mapping[str, Any], path: Path, line: int) -> JournalEntry:
    """Return the episode in a line of a journal.

    Args:
        row: Contents of the line.
        path: Path of the journal, for messages.
        line: Number of the line.

    Raises:
        JournalError: If the line holds no episode.
    """
    try:
        return _entry(row)
    except KeyError as error:
        raise damaged(path, line, f"it lacks {error}") from error
    except (TypeError, ValueError, AttributeError) as error:
        raise damaged(path, line, f"it is not an episode ({error})") from error


def require_usable(path: Path, identity: Mapping[str, Any]) -> None:
    """Check that the trial in a journal can be resumed.

    Args:
        path: Path of the journal, which exists.
        identity: Known parts of the trial's identity; other parts are not compared.

    Raises:
        JournalError: If it cannot be resumed; the message gives the reason.
        OSError: If the file cannot be read or written.
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
