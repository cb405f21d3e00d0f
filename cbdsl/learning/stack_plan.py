"""Plans of stacks: the surest paths through what is known to stand on what (Figure 7.17)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import prod
from typing import TYPE_CHECKING, NamedTuple

import networkx as nx

if TYPE_CHECKING:
    from cbdsl.learning.thing_graph import SupportGraph


class StackPlan(NamedTuple):
    """Things to be stacked.

    Attributes:
        order: of the things, from below.
        probability: that all of them stand, taken to be independent of each other.
    """

    order: tuple[str, ...]
    probability: float


def plan_stack(support: SupportGraph, height: int) -> StackPlan:
    """The surest stack of some height.

    Args:
        support: what stands on what, see ``support_graph``.
        height: number of things, 2 at least.

    Raises:
        ValueError: nothing that stood on another one makes such a stack.
    """
    plans = plan_stacks(support, height)
    if not plans:
        given = ", ".join(sorted(support)) or "nothing"
        raise ValueError(f"no stack of {height} is known of {given}")
    return plans[0]


def plan_stacks(support: SupportGraph, height: int) -> list[StackPlan]:
    """All stacks of some height that can be made, the surest first."""
    plans = [
        StackPlan(tuple(path), _probability(support, path))
        for lowest in support
        for path in nx.all_simple_paths(support, lowest, {*support} - {lowest}, cutoff=height - 1)
        if len(path) == height
    ]
    return sorted(plans, key=lambda plan: (-plan.probability, plan.order))


def pairs_of(support: SupportGraph, order: Sequence[str]) -> list[str]:
    """Names of the pairs that a stack is made of, from below."""
    return [support.edges[edge]["pair"] for edge in pairwise(order)]


def _probability(support: SupportGraph, path: list[str]) -> float:
    own: list[float] = [support.edges[edge]["probability"] for edge in pairwise(path)]
    return prod(own)
