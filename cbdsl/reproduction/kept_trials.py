"""Trials that are kept in a file as soon as they are over."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar


class ThingTrial(Protocol):
    """A trial of things.

    Attributes:
        things: by which names.
        seed: of its episode.
    """

    @property
    def things(self) -> str: ...

    @property
    def seed(self) -> int: ...

    def as_data(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        ...


Some = TypeVar("Some", bound=ThingTrial)


class KeptTrials(Generic[Some]):
    """Trials by things and seed; what is there already is not run again.

    Args:
        path: the file, a line of JSON for each trial; it need not be there.
        what: a digest of all that decides the outcome beside that; others are left alone.
        read: makes a trial of its data, or raises ValueError.
    """

    def __init__(self, path: Path, what: str, read: Callable[[Mapping[str, Any]], Some]) -> None:
        self._path, self._what = path, what
        self._known: dict[tuple[str, int], Some] = {}
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if text and not text.endswith("\n"):
            with path.open("a", encoding="utf-8") as file:
                file.write("\n")  # so that the next one has a line of its own
        for line in text.splitlines():
            try:
                row = json.loads(line)
                if row.pop("what") != what:
                    continue
                trial = read(row)
            except ValueError:
                continue  # cut off when the process was ended
            self._known[trial.things, trial.seed] = trial

    def get(self, things: str, seed: int) -> Some | None:
        """A trial that was run, if it was."""
        return self._known.get((things, seed))

    def add(self, trial: Some) -> None:
        """Keep a trial."""
        self._known[trial.things, trial.seed] = trial
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"what": self._what, **trial.as_data()}) + "\n")
