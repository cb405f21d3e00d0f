"""Policies: the action that follows a state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from cbdsl.types.state import closest_first, matches


class Policy(Protocol):
    """Choice of actions by state, written or learned."""

    def choose(self, state: str, *, changed: bool) -> str | None:
        """Return the next action's name, or ``None`` to end the episode.

        Args:
            state: Predicates, one character per member.
            changed: True if the last action changed the state.
        """
        ...


@runtime_checkable
class ReasonedPolicy(Protocol):
    """Policy that gives a reason if it has no action.

    Attributes:
        reason: Reason why the last choice was ``None``, as a clause; empty if the policy has no
            action.
    """

    reason: str

    def choose(self, state: str, *, changed: bool) -> str | None:
        """Choose the next action; see ``Policy.choose``."""
        ...


class DeferredPolicy:
    """Policy whose choices are made outside of it, between ticks, by the caller of the program.

    While a choice is open, the active controllers stay active; see ``ProgramRun.decide``.
    """

    def choose(self, state: str, *, changed: bool) -> str | None:
        """Refuse to choose an action; see ``Policy.choose``.

        Raises:
            TypeError: Always; the choice is not made here.
        """
        raise TypeError("a deferred choice is made by ProgramRun.decide")


class WrittenPolicy:
    """Table of state patterns; the matching pattern with the fewest wildcards applies.

    If an action times out without a change of state, the table would choose it again, so the
    episode ends.
    """

    def __init__(self, table: Mapping[str, str]) -> None:
        self._table = {pattern: table[pattern] for pattern in closest_first(table)}
        #: Actions of the states of previous choices.
        self._known: dict[str, str | None] = {}

    def choose(self, state: str, *, changed: bool) -> str | None:
        """Choose the next action; see ``Policy.choose``."""
        if not changed:
            return None
        if state not in self._known:
            patterns = (pattern for pattern in self._table if matches(pattern, state))
            first = next(patterns, None)
            self._known[state] = None if first is None else self._table[first]
        return self._known[state]
