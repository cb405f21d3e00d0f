"""Constant policy, for learners that have no program yet."""

from __future__ import annotations

from cbdsl.program.schema import NO_FEATURES, Features
from cbdsl.runtime.policies.policy import Choice, Policy


class Always(Policy):
    """Policy that always chooses the same action.

    Args:
        action: Name of the action.
    """

    def __init__(self, action: str) -> None:
        self._action = action

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Return the constant action (see ``Policy.choose``)."""
        return Choice(self._action)
