"""Written policies: tables as they are."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.program.policy_table import PolicyTable
from cbdsl.program.schema import NO_FEATURES, Features
from cbdsl.runtime.policies.policy import Choice, Policy


class WrittenPolicy(Policy):
    """Policy that follows a table of state patterns.

    If an action times out without a change of state, the table would choose it again, so the
    episode ends.

    Args:
        table: Action by state pattern.
    """

    def __init__(self, table: Mapping[str, str]) -> None:
        self._table = PolicyTable(table)

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Choose the next action; see ``Policy.choose``."""
        return Choice(self._table.find(state) if changed else None)
