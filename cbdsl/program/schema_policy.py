"""Policy of a schema: actions by the state, and their resources by the context."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Protocol, runtime_checkable

from cbdsl.program.attempts import AttemptProgress
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.schema import Ranking, Schema
from cbdsl.types.decision_tree import decide
from cbdsl.types.policy import Policy, ReasonedPolicy, WrittenPolicy
from cbdsl.types.state import Predicate

Features = Mapping[str, float]
"""Numbers by name, in SI; NaN where a signal is undefined."""

Rank = Callable[[Features], Ranking]
"""Ranking of the allocations by features, the most promising one first."""


@runtime_checkable
class ContextPolicy(ReasonedPolicy, Protocol):
    """Policy that depends on more than the state.

    Attributes:
        withdraws: True if the last choice was none only until the effectors have returned.
    """

    withdraws: bool

    def begin(self, read: Callable[[], Features]) -> None:
        """Begin an episode, in which ``read`` returns the current features."""
        ...

    def choose(self, state: str, *, changed: bool) -> str | None:
        """Choose the next action; see ``Policy.choose``."""
        ...


class SchemaPolicy:
    """Policy that chooses abstract actions by the declarative policy, and allocates them.

    An allocation is kept as long as it makes progress. After a failure the next one is tried, and
    none of them twice in an episode (Figure 5.9). Before the next attempt, the effectors return to
    their background posture, so that every allocation starts unobstructed. If allocations bring
    programs of their own, a new allocation starts from the initial state. It cannot continue from
    the outcome of another allocation's program, such as an object in a particular hand.

    Args:
        program: Schema with all allocated actions.
        rank: Function that ranks the allocations; the schema's own tree if ``None``.
        gives_up: True to begin nothing if reward is unlikely, as in execution; a learner tries
            regardless.
        declarative: Policy for the abstract actions, instead of the program's policy.
        persists: True to try all allocations again after each of them has failed.

    Attributes:
        reason: Reason for the last choice of no action; see ``ReasonedPolicy``.
        withdraws: True while the effectors return; see ``ContextPolicy``.
    """

    def __init__(
        self,
        program: CheckedProgram,
        rank: Rank | None = None,
        *,
        gives_up: bool = True,
        declarative: Policy | None = None,
        persists: bool = False,
    ) -> None:
        assert program.schema is not None
        self._schema: Schema = program.schema
        self._rank = rank or self._by_tree
        self._gives_up = gives_up
        self._progress = AttemptProgress(self._schema.worth)
        self._persists = persists
        self._declarative = declarative or WrittenPolicy(program.policy)
        self._actions: dict[str, dict[str, str]] = {}
        for action in program.actions:
            self._actions.setdefault(action.abstract, {})[action.allocation] = action.name
        self._brings_programs = any(
            action.program is not None and action.allocation for action in program.actions
        )
        self.begin(dict)

    def begin(self, read: Callable[[], Features]) -> None:
        """Begin an episode; see ``ContextPolicy.begin``."""
        self._read = read
        self._failed: set[str] = set()
        self._allocation = self._before = self.reason = ""
        self._is_informed = self.withdraws = self._begins_anew = False

    def choose(self, state: str, *, changed: bool) -> str | None:
        """Return the next action under its allocation, or ``None``; see ``reason``."""
        self.reason, self.withdraws = "", False
        before, self._before = self._before, state
        if self._allocation and self._progress.fails(before, state):
            self._begins_anew = self._brings_programs
            if self._is_informed:
                self._failed.add(self._allocation)
                self.withdraws = self._is_left()
            self._allocation, changed = "", True
        if self.withdraws:
            return None
        if self._begins_anew:
            state, self._begins_anew = Predicate.INACTIVE * len(state), False
        abstract = self._declarative.choose(state, changed=changed)
        if abstract is None:
            return None
        actions = self._actions[abstract]
        if "" in actions:
            self._allocation = ""
            return actions[""]
        if not self._allocation:
            self._allocation = self._allocate()
            self._progress.begin()
        return actions[self._allocation] if self._allocation else None

    def _is_left(self) -> bool:
        """Return whether another attempt may be made."""
        return self._persists or len(self._failed) < len(self._schema.allocations)

    def _allocate(self) -> str:
        """Return the best allocation that has not failed; if none is left, set the reason."""
        features = self._read()
        self._is_informed = are_defined(features)
        if self._gives_up and self._is_unlikely(features):
            return ""
        ranking = self._rank(features)
        left = [each for each in ranking if each not in self._failed]
        if not left and self._persists:
            self._failed.clear()
            return ranking[0]
        if not left:
            self.reason = "every allocation has been tried" + self._unknown(features)
            return ""
        return left[0]

    def _is_unlikely(self, features: Features) -> bool:
        likely = self._schema.reward_given(features)
        if likely is None or likely >= self._schema.least_reward:
            return False
        self.reason = f"reward is unlikely here ({100 * likely:.0f} %)"
        return True

    def _unknown(self, features: Features) -> str:
        """Return a note if the probability of reward was unknown, or nothing."""
        untried = self._schema.untried(features) if are_defined(features) else ()
        if not untried:
            return ""
        return f"; reward was unknown here ({', '.join(untried)} outside of all learned contexts)"

    def _by_tree(self, features: Features) -> Ranking:
        """Return the ranking of the schema's tree, followed by the allocations that it omits."""
        schema = self._schema
        known = None if schema.choice is None else decide(schema.choice, features)
        first = schema.otherwise if known is None else known
        return tuple(dict.fromkeys((*first, *schema.otherwise, *schema.allocations)))


def are_defined(features: Features) -> bool:
    """Return whether all features are defined."""
    return not any(math.isnan(value) for value in features.values())
