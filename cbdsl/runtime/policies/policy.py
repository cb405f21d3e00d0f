"""Policies: the action that follows a state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from cbdsl.program.policy_table import PolicyTable
from cbdsl.program.schema import NO_FEATURES, Features
from cbdsl.types.state import tells_rest


class Choice(NamedTuple):
    """Decision of a policy.

    Attributes:
        action: Name of the next action; ``None`` to end the episode.
        allocation: Allocation of a schema's abstract action; empty without one.
        reason: Reason why there is no action, as a clause; empty if the policy has none.
        withdraws: True if there is no action only until the effectors have returned to their
            background posture.
    """

    action: str | None
    allocation: str = ""
    reason: str = ""
    withdraws: bool = False


class Policy(Protocol):
    """Choice of actions by state, written or learned.

    Attributes:
        allocates: True if it needs the features of a schema. Programs that define undefined ones
            then run before its first choice.
        tells_rest: True if its states have different letters for arrival and for a stuck member.
    """

    allocates: bool = False
    tells_rest: bool = False

    def begin(self) -> None:
        """Begin an activation of the program."""
        return

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Return the next action.

        Args:
            state: Predicates, one character per member.
            changed: True if the last action changed the state.
            features: Features of the program's schema by name, in SI, NaN while undefined; empty
                without a schema.
        """
        ...


class DeferredPolicy(Policy):
    """Policy whose choices are made outside of it, between ticks, by the caller of the program.

    While a choice is open, the active controllers stay active; see ``ProgramRun.decide``.
    """

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Refuse to choose an action; see ``Policy.choose``.

        Raises:
            TypeError: Always; the choice is not made here.
        """
        raise TypeError("a deferred choice is made by ProgramRun.decide")


class WrittenPolicy(Policy):
    """Policy that follows a table of state patterns.

    If an action times out without a change of state, the table would choose it again, so the
    episode ends.

    Args:
        table: Action by state pattern.
    """

    def __init__(self, table: Mapping[str, str]) -> None:
        self._table = PolicyTable(table)
        self.tells_rest = tells_rest(table)

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Choose the next action; see ``Policy.choose``."""
        return Choice(self._table.find(state) if changed else None)
