"""Schemas: programs whose resources are allocated by the context (Section 5.3)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

from cbdsl.types.decision_tree import Tree, decide
from cbdsl.types.resource import Resource

Ranking = tuple[str, ...]
"""Names of allocations, the most promising one first."""

Features = Mapping[str, float]
"""Numbers by name, in SI; NaN where a signal is undefined."""

Rank = Callable[[Features], Ranking]
"""Ranking of the allocations by features, the most promising one first."""

NO_FEATURES: Features = MappingProxyType({})

# Share of a tried range by which a feature may exceed it, and still count as tried.
_MARGIN = 0.1

_AXES = ("x", "y", "z")


class Schema(NamedTuple):
    """Knowledge of a schema besides its declarative policy.

    Attributes:
        policy: Name of the declarative policy.
        features: Signals that determine the allocation, by name.
        allocations: Values of parameters by name of the allocation, the program's own first.
        choice: psi(a, f) of Eq 5.3, as a tree; ``None`` if unknown.
        otherwise: Allocations for an undefined feature.
        reward: Pr(reward | pi, f), as a tree; ``None`` if unknown.
        tried: Least and largest value of each component in the contexts that were learned from.
        least_reward: Probability of reward below which the schema is undefined.
        worth: Expected reward by state, if it was learned; it separates progress from failure.
    """

    policy: str
    features: Mapping[str, Resource]
    allocations: Mapping[str, Mapping[str, str]]
    choice: Tree[Ranking] | None = None
    otherwise: Ranking = ()
    reward: Tree[float] | None = None
    tried: Mapping[str, tuple[float, float]] = {}
    least_reward: float = 0.5
    worth: Mapping[str, float] = {}

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the numbers that make up the features, in the order of their signals."""
        return tuple(
            component
            for name, resource in self.features.items()
            for component in components(name, resource)
        )

    def untried(self, features: Mapping[str, float]) -> tuple[str, ...]:
        """Return the components whose values are unlike all that were tried.

        Undefined components are left out: a velocity, for example, is undefined in the first two
        images of an object, and the tree need not ask for it.

        Args:
            features: Features by name, in SI.
        """
        return tuple(
            name
            for name, (low, high) in self.tried.items()
            if not math.isnan(value := features.get(name, math.nan))
            and not _within(value, low, high)
        )

    def reward_given(self, features: Mapping[str, float]) -> float | None:
        """Return Pr(reward | pi, f), or ``None`` if it is unknown.

        It is unknown without a tree, where the tree asks for an undefined feature, and where a
        feature is unlike all that were tried.

        Args:
            features: Features by name, in SI.
        """
        # A tree has an answer for all numbers. Outside of the tried ranges it is an extrapolation.
        if self.reward is None or self.untried(features):
            return None
        return decide(self.reward, features)


def _within(value: float, low: float, high: float) -> bool:
    margin = _MARGIN * (high - low)
    return low - margin <= value <= high + margin


def components(name: str, resource: Resource) -> Iterator[str]:
    """Yield the names of a feature's components: its name, or its name with an axis or number."""
    size = resource.type.size
    if size == 1:
        yield name
    elif size == len(_AXES):
        yield from (f"{name}.{axis}" for axis in _AXES)
    else:
        yield from (f"{name}.{number}" for number in range(1, size + 1))
