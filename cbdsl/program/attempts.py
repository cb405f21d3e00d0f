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


def is_failure(before: str, after: str, worth: Mapping[str, float]) -> bool:
    """Whether a transition leads away from the reward, so that another allocation may be tried.

    Args:
        before, after: the states, equal where an action changed nothing.
        worth: expected reward by state; what is not there is worth nothing.
    """
    return before == after or worth.get(after, 0.0) < worth.get(before, 0.0)


def attempts(transitions: Iterable[Transition], worth: Mapping[str, float]) -> Iterator[Attempt]:
    """The attempts of an episode.

    Args:
        transitions: of a schema, in their order.
        worth: as of ``is_failure``.
    """
    allocation, features = "", dict[str, float]()
    for transition in transitions:
        if transition.allocation != allocation:
            if allocation:
                yield Attempt(allocation, features, False)
            allocation, features = transition.allocation, dict(transition.features)
        if not allocation:
            continue
        if transition.reward or is_failure(transition.state, transition.next_state, worth):
            yield Attempt(allocation, features, transition.reward > 0)
            allocation = ""
    if allocation:
        yield Attempt(allocation, features, False)
