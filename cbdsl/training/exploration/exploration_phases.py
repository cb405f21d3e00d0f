"""Phases of an exploration: the actions and the world that its journal names, in their order."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl.learning.catalogs.action_outcome import ActionOutcome, read_outcome, write_outcome
from cbdsl.storage.journal import Journal, JournalError, RowForm, require_same

# Parts that may change as actions join, or with the world; shared documents follow programs.
_JOINABLE = ("programs", "policies", "stage")
_NOUN = "exploration"


class Joined(NamedTuple):
    """Row of a journal for the actions and the world of a new phase.

    Attributes:
        parts: Joinable parts of the identity, as JSON data.
    """

    parts: Mapping[str, Any]


#: Row of an exploration's journal.
ActionRow = ActionOutcome | Joined


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


def phase(after: int, parts: Mapping[str, Any]) -> Phase:
    """Return the phase with some parts of an identity."""
    return Phase(after, tuple(parts["programs"]), parts["stage"])


def open_journal(
    path: Path, identity: Mapping[str, Any], *, joins: bool = False
) -> Journal[ActionRow]:
    """Open the journal of an exploration, and begin a new phase if its actions differ.

    Args:
        path: Path of the file; the exploration continues if the file exists.
        identity: All inputs of the actions, as JSON data.
        joins: True if other actions may join the existing actions, or another world may follow.

    Raises:
        JournalError: If the file belongs to another exploration, is no journal, or is being
            written.
        OSError: If the file cannot be read or written.
    """
    journal = Journal(path, identity, _ROWS, varying=True)
    try:
        _begin_phase(journal, identity, joins=joins)
    except BaseException:
        journal.close()
        raise
    return journal


# An identity has fixed parts, such as seed and constants, and joinable ones. The fixed parts have
# to be those of the file in any case. The joinable parts are those of the last phase, because a row
# with new ones begins each later phase. If the requested ones differ and others may join, a new
# phase begins. It may add actions and change the world, but removes no action. A replay thus meets
# each outcome with the actions that could be chosen then.
def _begin_phase(journal: Journal[ActionRow], identity: Mapping[str, Any], *, joins: bool) -> None:
    known, path = journal.identity, journal.path
    # A journal of another undertaking lacks these parts. The comparison then fails with a list of
    # the differences.
    if not _is_joinable(known):
        require_same(path, known, identity, _NOUN)
    current = _current(known, journal.rows)
    require_same(path, {**known, **_joinable(identity)}, identity, _NOUN)
    if current != _joinable(identity):
        _require_joinable(path, {**known, **current}, identity, joins=joins)
        journal.append(Joined(_joinable(identity)))


def _current(identity: Mapping[str, Any], rows: Iterable[ActionRow]) -> Mapping[str, Any]:
    """Return the joinable parts of the last phase."""
    parts: Mapping[str, Any] = _joinable(identity)
    for row in rows:
        if isinstance(row, Joined):
            parts = row.parts
    return parts


def _joinable(identity: Mapping[str, Any]) -> dict[str, Any]:
    return {key: identity[key] for key in (*_JOINABLE, "shared") if key in identity}


def _is_joinable(row: object) -> bool:
    """Return whether a row of a file has actions, policies and world."""
    return isinstance(row, dict) and all(isinstance(row.get(key), dict) for key in _JOINABLE)


def _require_joinable(
    path: Path, known: Mapping[str, Any], requested: Mapping[str, Any], *, joins: bool
) -> None:
    """Check that requested actions join the existing actions, and remove none of them.

    Raises:
        JournalError: If they do not.
    """
    try:
        if joins:
            there = {key: known[key] for key in ("programs", "policies")}
            kept = {
                key: {name: requested[key].get(name) for name in names}
                for key, names in there.items()
            }
            require_same(path, there, kept, _NOUN)
        else:
            require_same(path, known, requested, _NOUN)
    except JournalError as error:
        hint = "the earlier programs and policies remain" if joins else "with --join others join it"
        raise JournalError(f"{error}; {hint}") from None


def _read(row: Mapping[str, Any]) -> ActionRow:
    if "joined" not in row:
        return read_outcome(row)
    if not _is_joinable(row["joined"]):
        raise ValueError("it names no actions, policies and stage that joined")
    return Joined(row["joined"])


def _write(row: ActionRow) -> Mapping[str, Any]:
    return {"joined": dict(row.parts)} if isinstance(row, Joined) else write_outcome(row)


_ROWS: RowForm[ActionRow] = RowForm(_NOUN, "an action", _read, _write)
