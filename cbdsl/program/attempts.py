"""Attempts: stretches of an episode under one allocation, and whether they led to reward."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from cbdsl.program.transition import Transition


class Attempt(NamedTuple):
    """An allocation in a context.

    Attributes:
        allocation: its name.
        features: by name, when it was chosen.
        rewarded: whether reward followed before it was given up.
    """

    allocation: str
    features: Mapping[str, float]
    rewarded: bool


# What hides a thing for a moment, as a hand on its way does, is no failure.
_SETBACKS = 1


class AttemptProgress:
    """The progress of one attempt towards the reward.

    Args:
        worth: expected reward by state; what is not there is worth nothing.
    """

    def __init__(self, worth: Mapping[str, float]) -> None:
        self._worth = worth
        self.begin()

    def begin(self) -> None:
        """Another attempt."""
        self._is_first, self._setbacks = True, 0

    def fails(self, before: str, after: str) -> bool:
        """Whether the next transition ends it, so that another allocation may be tried.

        It fails where an action changes nothing, where it would be better to begin anew, and where
        it loses ground for the second time. The first transition tells what the attempt before has
        left, and is no loss. Out of sight is ground lost, and found again by whoever looks for it.

        Args:
            before, after: the states, equal where an action changed nothing.
        """
        is_first, self._is_first = self._is_first, False
        now, earlier = self._worth.get(after, 0.0), self._worth.get(before, 0.0)
        is_worse = now < self._worth.get("X" * len(after), 0.0)
        if before == after or (is_worse and not _is_undefined(after)):
            return True
        self._setbacks += now < earlier and not is_first
        return self._setbacks > _SETBACKS


def _is_undefined(state: str) -> bool:
    """Whether nothing that was tried is defined."""
    return "-" in state and not set(state) & {"0", "1"}


def attempts(transitions: Iterable[Transition], worth: Mapping[str, float]) -> Iterator[Attempt]:
    """The attempts of an episode.

    Args:
        transitions: of a schema, in their order.
        worth: as of ``AttemptProgress``.
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
        if transition.reward or progress.fails(transition.state, transition.next_state):
            yield Attempt(allocation, features, transition.reward > 0)
            allocation = ""
    if allocation:
        yield Attempt(allocation, features, False)
