"""Plans of stacks: the surest path through what is known to stand on what (Figure 7.17)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

Support = Mapping[tuple[str, str], float]
"""Probabilities that a thing stands on another one, by upper and lower."""


class StackPlan(NamedTuple):
    """Things to be stacked.

    Attributes:
        order: of the things, from below.
        probability: that all of them stand, taken to be independent of each other.
    """

    order: tuple[str, ...]
    probability: float


def plan_stack(support: Support, height: int, things: Collection[str] | None = None) -> StackPlan:
    """The surest stack of some height.

    Args:
        support: what stands on what, and how surely.
        height: number of things, 2 at least.
        things: that are there; all that are known without.

    Raises:
        ValueError: nothing that stood on another one makes such a stack.
    """
    there = things if things is not None else {name for pair in support for name in pair}
    edges = {
        (upper, lower): probability
        for (upper, lower), probability in support.items()
        if probability > 0.0 and upper in there and lower in there
    }
    plans = [plan for lowest in sorted(there) for plan in _stacks((lowest,), 1.0, edges, height)]
    if height < 2 or not plans:
        raise ValueError(f"no stack of {height} is known of {', '.join(sorted(there)) or 'nothing'}")
    return max(plans, key=lambda plan: (plan.probability, plan.order))


def _stacks(
    order: tuple[str, ...], probability: float, edges: Support, height: int
) -> Iterator[StackPlan]:
    """All stacks that begin so."""
    if len(order) == height:
        yield StackPlan(order, probability)
        return
    for (upper, lower), own in edges.items():
        if lower == order[-1] and upper not in order:
            yield from _stacks((*order, upper), probability * own, edges, height)


def mean_of(rewarded: int, tried: int) -> float:
    """Mean of the probability of a reward, by Laplace's rule; 0 where it was never rewarded."""
    return (rewarded + 1) / (tried + 2) if rewarded else 0.0
