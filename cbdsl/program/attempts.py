"""Attempts: stretches of an episode under one allocation, and whether they led to reward."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from cbdsl.program.transition import Transition


# Model: V(s) is the expected discounted reward of a state s, see ``state_values``. A transition
# from s to s' ends an unrewarded attempt in three cases:
#     s' = s                         the action changed nothing within its time
#     V(s') < V(X...X)               a defined state is worth less than the initial state
#     V(s') < V(s), second time      the attempt loses ground again
# Only the order of the values matters, so that they need not have converged. Without learned
# values, V is 0 in all states, and only an unchanged state ends an attempt.
class Attempt(NamedTuple):
    """Allocation in a context.

    Attributes:
        allocation: Name of the allocation.
        features: Features by name, at the time of the choice; those undefined then, such as a
            velocity in the first image, when they were defined first.
        rewarded: True if reward followed before the attempt was given up.
    """

    allocation: str
    features: Mapping[str, float]
    rewarded: bool


# A short occlusion, for example by a hand on its way, is no failure.
_SETBACKS = 1


class AttemptProgress:
    """Progress of one attempt towards the reward.

    Args:
        worth: Expected reward by state; 0 for missing states.
    """

    def __init__(self, worth: Mapping[str, float]) -> None:
        self._worth = worth
        self.begin()

    def begin(self) -> None:
        """Begin another attempt."""
        self._is_first, self._setbacks = True, 0

    def fails(self, before: str, after: str) -> bool:
        """Return whether the next transition ends the attempt, so that another can be tried.

        An attempt fails if an action changes nothing or if it loses ground for the second time.
        It also fails in a defined state that is worth less than the initial one. The first
        transition is never a loss, because it shows the outcome of the previous attempt. A state
        in which the object is out of sight counts as lost ground, which a search can regain.

        Args:
            before: State before the action.
            after: State after it, equal to ``before`` if the action changed nothing.
        """
        is_first, self._is_first = self._is_first, False
        now, earlier = self._worth.get(after, 0.0), self._worth.get(before, 0.0)
        is_worse = now < self._worth.get("X" * len(after), 0.0)
        if before == after or (is_worse and not _is_undefined(after)):
            return True
        self._setbacks += now < earlier and not is_first
        return self._setbacks > _SETBACKS


def _is_undefined(state: str) -> bool:
    """Return whether a state has undefined predicates, and no transient or quiescent ones."""
    return "-" in state and not set(state) & {"0", "1"}


def attempts(transitions: Iterable[Transition], worth: Mapping[str, float]) -> Iterator[Attempt]:
    """Yield the attempts of an episode.

    Args:
        transitions: Transitions of a schema, in order.
        worth: Expected reward by state, as in ``AttemptProgress``.
    """
    allocation, features, progress = "", dict[str, float](), AttemptProgress(worth)
    for transition in transitions:
        if transition.allocation != allocation:
            if allocation:
                yield Attempt(allocation, features, False)
            allocation, features = transition.allocation, dict(transition.features)
            progress.begin()
        if not allocation:
            continue
        features = {**transition.features, **features}
        if transition.reward or progress.fails(transition.state, transition.next_state):
            yield Attempt(allocation, features, transition.reward > 0)
            allocation = ""
    if allocation:
        yield Attempt(allocation, features, False)
