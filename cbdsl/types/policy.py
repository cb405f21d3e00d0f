"""Policies: the action that follows a state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from cbdsl.types.state import closest_first, matches


class Policy(Protocol):
    """Choice of actions by state, written or learned."""

    def choose(self, state: str, *, changed: bool) -> str | None:
        """The next action's name, or ``None`` to end the episode.

        Args:
            state: predicates, one character per member.
            changed: whether the last action changed the state.
        """
        ...


@runtime_checkable
class ReasonedPolicy(Protocol):
    """A policy that says why it has no action.

    Attributes:
        reason: why the last choice was none, as a clause; empty where the policy has no action.
    """

    reason: str

    def choose(self, state: str, *, changed: bool) -> str | None:
        """See ``Policy.choose``."""
        ...


class DeferredPolicy:
    """Choice from outside, between ticks: whoever runs the program decides there.

    While a choice is open nothing acts but what acted before; see ``ProgramRun.decide``.
    """

    def choose(self, state: str, *, changed: bool) -> str | None:
        """See ``Policy.choose``.

        Raises:
            TypeError: always; the choice is not made here.
        """
        raise TypeError("a deferred choice is made by ProgramRun.decide")


class WrittenPolicy:
    """A table of state patterns, of which the one with the fewest wildcards applies.

    Where an action ran out of time without a change of state, the same table would choose it
    again, so the episode ends.
    """

    def __init__(self, table: Mapping[str, str]) -> None:
        self._table = {pattern: table[pattern] for pattern in closest_first(table)}
        #: Actions of the states that have been asked about.
        self._known: dict[str, str | None] = {}

    def choose(self, state: str, *, changed: bool) -> str | None:
        """See ``Policy.choose``."""
        if not changed:
            return None
        if state not in self._known:
            patterns = (pattern for pattern in self._table if matches(pattern, state))
            first = next(patterns, None)
            self._known[state] = None if first is None else self._table[first]
        return self._known[state]
