"""Plans of stacks: the surest paths through what is known to stand on what (Figure 7.17)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from cbdsl.documents.meta_catalog import MetaCatalogDocument

Support = Mapping[tuple[str, str], float]
"""Probabilities that a thing stands on another one, by upper and lower; 0 where it never did."""


class StackPlan(NamedTuple):
    """Things to be stacked.

    Attributes:
        order: of the things, from below.
        probability: that all of them stand, taken to be independent of each other.
    """

    order: tuple[str, ...]
    probability: float


def support_of(catalog: MetaCatalogDocument) -> dict[tuple[str, str], float]:
    """Probabilities of a meta-catalog that one thing stands on another, by Laplace's rule."""
    return {
        (pair.upper, pair.lower): (pair.rewarded + 1) / (pair.tried + 2) if pair.rewarded else 0.0
        for pair in catalog.pairs.values()
        if pair.relation == "on"
    }


def plan_stack(support: Support, height: int, things: Collection[str] | None = None) -> StackPlan:
    """The surest stack of some height.

    Args:
        support: what stands on what, and how surely.
        height: number of things, 2 at least.
        things: that are there; all that are known without.

    Raises:
        ValueError: nothing that stood on another one makes such a stack.
    """
    plans = plan_stacks(support, height, things)
    if not plans:
        known = {name for pair in support for name in pair} if things is None else set(things)
        given = ", ".join(sorted(known)) or "nothing"
        raise ValueError(f"no stack of {height} is known of {given}")
    return plans[0]


def plan_stacks(
    support: Support, height: int, things: Collection[str] | None = None
) -> list[StackPlan]:
    """All stacks of some height that can be made, the surest first."""
    edges = {
        pair: probability
        for pair, probability in support.items()
        if probability > 0.0 and (things is None or set(pair) <= set(things))
    }
    lowest = sorted({lower for _, lower in edges})
    plans = [plan for low in lowest for plan in _stacks((low,), 1.0, edges, height)]
    return sorted(plans, key=lambda plan: (-plan.probability, plan.order))


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
