"""Learned policies: tables that know when they are of no use."""

from __future__ import annotations

from collections import Counter

from cbdsl.program.checked import CheckedProgram
from cbdsl.types.policy import WrittenPolicy
from cbdsl.types.state import at_rest_anew

# Where an object slips away time and again, as many as four approaches have led to a grasp.
_PATIENCE = 8


class LearnedPolicy:
    """Chooses as a learned table does, and ends where that goes in circles.

    While a table is learned, exploration leads out of every circle; without it, where nothing can
    be rewarded, the same actions would follow each other until the transitions are used up. So the
    policy has no action where a program has just failed that it would only start again, and where
    the same transition to rest has come about several times.

    Args:
        program: runs under its learned policy.

    Attributes:
        reason: why the last choice was none, as a clause; empty where the table has no action.
    """

    def __init__(self, program: CheckedProgram) -> None:
        self._table = WrittenPolicy(program.policy)
        self._places = {
            action.name: program.members.index(action.part)
            for action in program.actions
            if action.program is not None and action.composition is None
        }
        # Where references are drawn, the next round goes elsewhere.
        self._counts_rests = program.reward_ends and not any(
            each.is_drawn for action in program.actions for each in action.controllers
        )
        self._begin("")

    def _begin(self, state: str) -> None:
        self.reason = ""
        self._state, self._action = state, ""
        self._rests: Counter[tuple[str, str]] = Counter()

    def choose(self, state: str, *, changed: bool) -> str | None:
        """See ``Policy.choose``; a state without active members begins anew."""
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
