"""Plans of stacks: the most probable paths through known support relations (Figure 7.17)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import prod
from typing import TYPE_CHECKING, NamedTuple

import networkx as nx

if TYPE_CHECKING:
    from cbdsl.learning.catalogs.thing_graph import SupportGraph


class StackPlan(NamedTuple):
    """Plan of a stack of objects.

    Attributes:
        order: Names of the objects, from bottom to top.
        probability: Probability that all objects stand, assuming independence.
    """

    order: tuple[str, ...]
    probability: float


def plan_stack(support: SupportGraph, height: int) -> StackPlan:
    """Return the most probable stack of a height.

    Args:
        support: Graph of objects that stood on others, see ``support_graph``.
        height: Number of objects, at least 2.

    Raises:
        ValueError: If no known support relations make such a stack.
    """
    plans = plan_stacks(support, height)
    if not plans:
        given = ", ".join(sorted(support)) or "nothing"
        raise ValueError(f"no stack of {height} is known of {given}")
    return plans[0]


def plan_stacks(support: SupportGraph, height: int) -> list[StackPlan]:
    """Return all possible stacks of a height, the most probable first."""
    # A simple path uses each object once, and ``cutoff`` counts its edges. There are at most
    # n! / (n - height)! paths of that height with n objects, few enough for objects on a table.
    plans = [
        StackPlan(tuple(path), _probability(support, path))
        for lowest in support
        for path in nx.all_simple_paths(support, lowest, {*support} - {lowest}, cutoff=height - 1)
        if len(path) == height
    ]
    return sorted(plans, key=lambda plan: (-plan.probability, plan.order))


def pairs_of(support: SupportGraph, order: Sequence[str]) -> list[str]:
    """Return the names of the pairs in a stack, from bottom to top."""
    return [support.edges[edge]["pair"] for edge in pairwise(order)]


def _probability(support: SupportGraph, path: list[str]) -> float:
    own: list[float] = [support.edges[edge]["probability"] for edge in pairwise(path)]
    return prod(own)
