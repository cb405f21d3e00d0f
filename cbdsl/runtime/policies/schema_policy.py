"""Policy of a schema: actions by the state, and their resources by the context."""

from __future__ import annotations

import math

from cbdsl.program.attempts import AttemptProgress
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.schema import NO_FEATURES, Features, Rank, Ranking, Schema
from cbdsl.runtime.policies.policy import Choice, Policy, WrittenPolicy
from cbdsl.types.decision_tree import decide
from cbdsl.types.state import Predicate


class SchemaPolicy(Policy):
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
    """

    allocates = True

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
        self._allocated = {each.abstract for each in program.actions if each.allocation}
        self._brings_programs = any(
            action.program is not None and action.allocation for action in program.actions
        )
        self.begin()

    def begin(self) -> None:
        """Begin an episode; see ``Policy.begin``."""
        self._failed: set[str] = set()
        self._allocation = self._before = ""
        self._is_informed = self._begins_anew = False
        self._declarative.begin()

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Return the next action under its allocation; see ``Policy.choose``."""
        before, self._before = self._before, state
        if self._allocation and self._progress.fails(before, state):
            # A failure is a change even in the same state. Otherwise the policy would end the
            # episode, because the action changed nothing.
            self._begins_anew = self._brings_programs
            failed, self._allocation, changed = self._allocation, "", True
            # An allocation that was chosen without all features may be tried again with them.
            if self._is_informed:
                self._failed.add(failed)
                if self._is_left():
                    return Choice(None, withdraws=True)
        if self._begins_anew:
            state, self._begins_anew = Predicate.INACTIVE * len(state), False
        choice = self._declarative.choose(state, changed=changed)
        if choice.action is None:
            return choice
        if choice.action not in self._allocated:
            self._allocation = ""
            return choice
        if not self._allocation:
            self._allocation, reason = self._allocate(features)
            self._progress.begin()
            if reason:
                return Choice(None, reason=reason)
        return choice._replace(allocation=self._allocation)

    def _is_left(self) -> bool:
        """Return whether another attempt may be made."""
        return self._persists or len(self._failed) < len(self._schema.allocations)

    def _allocate(self, features: Features) -> tuple[str, str]:
        """Return the best allocation that has not failed, or else the reason why there is none."""
        self._is_informed = are_defined(features)
        likely = self._schema.reward_given(features) if self._gives_up else None
        if likely is not None and likely < self._schema.least_reward:
            return "", f"reward is unlikely here ({100 * likely:.0f} %)"
        ranking = self._rank(features)
        left = [each for each in ranking if each not in self._failed]
        if left:
            return left[0], ""
        if not self._persists:
            return "", "every allocation has been tried" + self._unknown(features)
        self._failed.clear()
        return ranking[0], ""

    def _unknown(self, features: Features) -> str:
        """Return a note if the probability of reward was unknown, or nothing."""
        untried = self._schema.untried(features)
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
