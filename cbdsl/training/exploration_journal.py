"""Journal of an exploration: the completed actions, and the actions that joined later."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self, TypeGuard

from cbdsl.runtime.line_journal import JournalError, LineJournal, damaged, require_same

# Parts of the identity that may change when actions join, or when the world changes.
_JOINABLE = ("programs", "policies", "stage")


class Phase(NamedTuple):
    """Part of an exploration with the same actions in the same world.

    Attributes:
        after: Number of actions completed in earlier phases.
        programs: Names of the actions.
        stage: Name and digest of the world, as JSON data.
    """

    after: int
    programs: tuple[str, ...]
    stage: Mapping[str, Any]


class ExplorationJournal:
    """Journal of actions, each written when it is over.

    Args:
        path: Path of the file; the exploration continues if the file exists.
        identity: All inputs of the actions, as JSON data.
        joins: True if other actions may join the existing actions, or another world may follow.

    Attributes:
        path: Path of the file.
        rows: Actions read from the file, with the numbers of their lines.
        phases: Phases in their order; the last one goes on.

    Raises:
        JournalError: If the file belongs to another exploration, is no journal, or is being
            written.
        OSError: If the file cannot be read or written.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any], *, joins: bool = False) -> None:
        begun = {**identity, **{key: _first(path).get(key, identity[key]) for key in _JOINABLE}}
        self._lines = LineJournal(path, begun, "exploration")
        try:
            self.path, self.rows = path, list[tuple[int, dict[str, Any]]]()
            self.phases = [_phase(0, begun)]
            wanted = {key: identity[key] for key in _JOINABLE}
            now = self._take_up({key: begun[key] for key in _JOINABLE})
            if now != wanted:
                _require_joinable(path, {**begun, **now}, identity, joins=joins)
                self._lines.append_row({"joined": wanted})
                self.phases.append(_phase(len(self.rows), wanted))
        except BaseException:
            self._lines.__exit__(None, None, None)
            raise

    def _take_up(self, now: Mapping[str, Any]) -> Mapping[str, Any]:
        """Sort the rows of the file; return the last phase's actions and world."""
        for line, row in enumerate(self._lines.rows, 2):
            if "joined" in row:
                now = row["joined"]
                if not _is_joinable(now):
                    raise damaged(self.path, line, "it says not what joined", "exploration")
                self.phases.append(_phase(len(self.rows), now))
            else:
                self.rows.append((line, row))
        return now

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._lines.__exit__(kind, error, traceback)

    def append_row(self, row: Mapping[str, Any]) -> None:
        """Append an action and flush it to disk.

        Raises:
            OSError: If the action cannot be written.
        """
        self._lines.append_row(row)


def _phase(after: int, known: Mapping[str, Any]) -> Phase:
    return Phase(after, tuple(known["programs"]), known["stage"])


def _first(path: Path) -> Mapping[str, Any]:
    """Return the identity at the beginning of a file; empty if none can be read."""
    if not path.is_file():
        return {}
    with path.open("rb") as file:
        line = file.readline()
    try:
        row = json.loads(line) if line.endswith(b"\n") else {}
    except (ValueError, RecursionError):
        return {}
    return row if _is_joinable(row) else {}


def _is_joinable(row: object) -> TypeGuard[Mapping[str, Any]]:
    """Return whether a row of a file has actions, policies and world."""
    return isinstance(row, dict) and all(isinstance(row.get(key), dict) for key in _JOINABLE)


def _require_joinable(
    path: Path, known: Mapping[str, Any], wanted: Mapping[str, Any], *, joins: bool
) -> None:
    """Check that requested actions join the existing actions, and remove none of them.

    Raises:
        JournalError: If they do not.
    """
    try:
        if joins:
            there = {key: known[key] for key in ("programs", "policies")}
            kept = {
                key: {name: wanted[key].get(name) for name in own} for key, own in there.items()
            }
            require_same(path, there, kept, "exploration")
        else:
            require_same(path, known, wanted, "exploration")
    except JournalError as error:
        hint = "what was there has to stay" if joins else "with --join others join it"
        raise JournalError(f"{error}; {hint}") from None
