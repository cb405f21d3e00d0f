"""Learned policies: tables that end if they make no progress."""

from __future__ import annotations

from collections import Counter

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.policy_table import PolicyTable
from cbdsl.program.schema import NO_FEATURES, Features
from cbdsl.runtime.policies.policy import Choice, Policy, WrittenPolicy
from cbdsl.runtime.policies.schema_policy import SchemaPolicy
from cbdsl.types.state import at_rest_anew

# If an object slips away repeatedly, up to four approaches have preceded a grasp.
_PATIENCE = 8


class LearnedPolicy(Policy):
    """Policy that follows a learned table and ends if the table runs in circles.

    During learning, exploration leads out of every circle. Without exploration and without
    possible reward, the same actions would repeat until the transitions are used up. So the
    policy has no action if it would only restart a program that has just failed. It has none
    either if the same transition to rest has occurred several times.

    Args:
        program: Program that runs under its learned policy.
    """

    def __init__(self, program: CheckedProgram) -> None:
        self._table = PolicyTable(program.policy)
        self._places = {
            action.name: program.members.index(action.part)
            for action in program.actions
            if action.program is not None and action.composition is None
        }
        # A condition that becomes true has the letter of rest, and takes no time.
        self._acting = len(program.members) - len(program.conditions)
        # If references are drawn, the next round leads elsewhere.
        self._counts_rests = program.reward_ends and not any(
            each.is_drawn for action in program.actions for each in action.controllers
        )
        self._restart("")

    def _restart(self, state: str) -> None:
        self._state, self._action = state, ""
        self._rests: Counter[tuple[str, str]] = Counter()

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Choose an action as ``Policy.choose``; a state without active members restarts."""
        if set(state) == {"X"}:
            self._restart(state)
        name = self._table.find(state) if changed else None
        if name is None:
            return Choice(None)
        # Both checks precede the update, because they compare with the preceding choice.
        reason = self._failed(state, name) or self._circles(state)
        self._state, self._action = state, name
        return Choice(None if reason else name, reason=reason)

    def _failed(self, state: str, name: str) -> str:
        again = name == self._action and name in self._places
        if not (again and state[self._places[name]] == "-"):
            return ""
        return f"{name} has failed, and to start it again is all that was learned for {state}"

    def _circles(self, state: str) -> str:
        before, after = self._state[: self._acting], state[: self._acting]
        if not (self._counts_rests and at_rest_anew(before, after)):
            return ""
        self._rests[self._state, state] += 1
        count = self._rests[self._state, state]
        if count < _PATIENCE:
            return ""
        return f"it goes in circles: {self._state} -> {state} {count} times without a reward"


def own_policy(program: CheckedProgram) -> Policy:
    """Return the policy of a schema, a learned table or a written one, at its beginning."""
    if program.schema is not None:
        return SchemaPolicy(program)
    return LearnedPolicy(program) if program.is_learned else WrittenPolicy(program.policy)
