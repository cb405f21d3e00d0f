"""Learned policies: tables that end if they make no progress."""

from __future__ import annotations

from collections import Counter

from cbdsl.program.checked import CheckedProgram
from cbdsl.types.policy import WrittenPolicy
from cbdsl.types.state import at_rest_anew

# If an object slips away repeatedly, up to four approaches have preceded a grasp.
_PATIENCE = 8


class LearnedPolicy:
    """Policy that follows a learned table and ends if the table runs in circles.

    During learning, exploration leads out of every circle. Without exploration and without
    possible reward, the same actions would repeat until the transitions are used up. So the
    policy has no action if it would only restart a program that has just failed. It has none
    either if the same transition to rest has occurred several times.

    Args:
        program: Program that runs under its learned policy.

    Attributes:
        reason: Reason for the last choice of no action, as a clause; empty if the table has none.
    """

    def __init__(self, program: CheckedProgram) -> None:
        self._table = WrittenPolicy(program.policy)
        self._places = {
            action.name: program.members.index(action.part)
            for action in program.actions
            if action.program is not None and action.composition is None
        }
        # If references are drawn, the next round leads elsewhere.
        self._counts_rests = program.reward_ends and not any(
            each.is_drawn for action in program.actions for each in action.controllers
        )
        self._begin("")

    def _begin(self, state: str) -> None:
        self.reason = ""
        self._state, self._action = state, ""
        self._rests: Counter[tuple[str, str]] = Counter()

    def choose(self, state: str, *, changed: bool) -> str | None:
        """Choose an action as ``Policy.choose``; a state without active members restarts."""
        if set(state) == {"X"}:
            self._begin(state)
        name = self._table.choose(state, changed=changed)
        if name is None:
            return None
        self.reason = self._failed(state, name) or self._circles(state)
        self._state, self._action = state, name
        return None if self.reason else name

    def _failed(self, state: str, name: str) -> str:
        again = name == self._action and name in self._places
        if not (again and state[self._places[name]] == "-"):
            return ""
        return f"{name} has failed, and to start it again is all that was learned for {state}"

    def _circles(self, state: str) -> str:
        if not (self._counts_rests and at_rest_anew(self._state, state)):
            return ""
        self._rests[self._state, state] += 1
        count = self._rests[self._state, state]
        if count < _PATIENCE:
            return ""
        return f"it goes in circles: {self._state} -> {state} {count} times without a reward"
