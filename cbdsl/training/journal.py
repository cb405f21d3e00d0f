"""The journal of a trial: one line per finished episode, from which it can go on."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any

from cbdsl.errors.errors import UsageError
from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition


class JournalError(UsageError):
    """A journal cannot be used; the message says why and what to do."""


class Journal:
    """A file of JSON lines: what the trial is, then each episode as soon as it is over.

    Where the file is there, the trial goes on.
    A line that a killed process left unfinished counts for nothing, and is overwritten.

    Args:
        path: the file.
        identity: all that the episodes depend on, as JSON has it.

    Attributes:
        finished: the episodes that the file holds.

    Raises:
        JournalError: the file belongs to another trial, or is none.
        OSError: it cannot be read or written.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any]) -> None:
        lines, sound = _whole_lines(path) if path.exists() else ([], 0)
        if lines:
            _require_same(path, lines[0], identity)
        self.finished = tuple(_experience(row) for row in lines[1:])
        self._file = path.open("r+b" if path.exists() else "w+b")
        try:
            self._file.truncate(sound)
            self._file.seek(sound)
            if not lines:
                self._append(dict(identity))
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._file.close()

    def append(self, experience: Experience, wall_seconds: float) -> None:
        """Keep a finished episode, for certain, before anything else happens.

        Args:
            experience: the episode.
            wall_seconds: how long it took; for people.

        Raises:
            OSError: it cannot be written.
        """
        self._append({**asdict(experience), "wall_seconds": round(wall_seconds, 3)})

    def _append(self, row: Mapping[str, Any]) -> None:
        self._file.write(json.dumps(row, ensure_ascii=False).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())


def _whole_lines(path: Path) -> tuple[list[dict[str, Any]], int]:
    """The lines of a file that are finished, and where they end."""
    data = path.read_bytes()
    sound = data.rfind(b"\n") + 1
    try:
        rows = [json.loads(line) for line in data[:sound].splitlines()]
        if not all(isinstance(row, dict) for row in rows):
            raise ValueError("a line is no JSON object")
    except ValueError as error:
        raise JournalError(f"{path} is no journal of a trial: {error}") from error
    return rows, sound


def _require_same(path: Path, found: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    differing = [key for key in {**found, **wanted} if found.get(key) != wanted.get(key)]
    if differing:
        told = "; ".join(f"{key} was {found.get(key)}, is {wanted.get(key)}" for key in differing)
        raise JournalError(f"{path} belongs to another trial: {told}; choose another --out")


def _experience(row: Mapping[str, Any]) -> Experience:
    transitions = (
        Transition(**{**each, "rewarding": tuple(each["rewarding"])}) for each in row["transitions"]
    )
    return Experience(
        context=row["context"],
        seed=row["seed"],
        transitions=tuple(transitions),
        rewarded={effector: tuple(angles) for effector, angles in row["rewarded"].items()},
        ticks=row["ticks"],
        sim_seconds=row["sim_seconds"],
    )
