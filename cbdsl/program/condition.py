"""Conditions of a program: three-valued comparisons of signals, resolved and in SI."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.types.resource import Origin, Resource

# Types without negative values.
_NOT_NEGATIVE = frozenset({"volume", "count", "probability", "extent", "distance", "likeness"}) | {
    "length"
}
_AT_MOST_ONE = frozenset({"probability", "likeness"})
_ALWAYS_DEFINED = frozenset({Origin.PROPRIOCEPTION, Origin.KINEMATICS, Origin.CONSTANT})
# Combinations of values up to which a condition is examined.
_MOST = 20_000


class Component(NamedTuple):
    """Component of a resource's value."""

    resource: Resource
    axis: int


class SumComparison(NamedTuple):
    """Comparison of a sum of components with 0.

    Attributes:
        factors: Factor of each component.
        constant: Constant of the sum, in SI.
        is_strict: True if the sum has to be above 0; otherwise, 0 is enough.
    """

    factors: Mapping[Component, float]
    constant: float
    is_strict: bool


class ProgramCondition(NamedTuple):
    """Condition that a program's exits name.

    Attributes:
        name: Name in the program.
        text: Condition as written, with the values of parameters.
        parts: Comparisons, and ``and``, ``or`` and ``not`` behind their operands.
        hold: Time for which its comparisons have to hold, s.
    """

    name: str
    text: str
    parts: tuple[SumComparison | str, ...]
    hold: float

    @property
    def comparisons(self) -> tuple[SumComparison, ...]:
        """Its comparisons."""
        return tuple(part for part in self.parts if isinstance(part, SumComparison))

    @property
    def resources(self) -> tuple[Resource, ...]:
        """Resources that it reads, each once."""
        components = (each for comparison in self.comparisons for each in comparison.factors)
        return tuple(dict.fromkeys(component.resource for component in components))

    @property
    def is_always_defined(self) -> bool:
        """True if it is true or false in every tick."""
        return all(each.origin in _ALWAYS_DEFINED for each in self.resources)

    def constant(self) -> bool | None:
        """Return the only value that it ever has while it is defined; ``None`` if it has both."""
        # A comparison changes its value where its sum passes 0. Different sums of signals vary
        # independently of each other, so that all combinations of values around these places show
        # all values of the condition.
        places: dict[tuple[tuple[Component, float], ...], set[float]] = {}
        keys = [_direction(each) for each in self.comparisons]
        for (key, scale), each in zip(keys, self.comparisons, strict=True):
            if key:
                places.setdefault(key, set()).add(-each.constant / scale)
        values = [_around(key, own) for key, own in places.items()]
        if math.prod(map(len, values)) > _MOST:
            return None
        outcomes = set()
        for chosen in itertools.product(*values):
            sums = dict(zip(places, chosen, strict=True))
            truths = [_is_met(c, scale * sums.get(key, 0.0) + c.constant)
                      for (key, scale), c in zip(keys, self.comparisons, strict=True)]  # fmt: skip
            outcomes.add(self._value(truths))
            if len(outcomes) == 2:
                return None
        return outcomes.pop()

    def _value(self, truths: Sequence[bool]) -> bool:
        """Return its value for those of its comparisons."""
        waiting, stack = list(truths), list[bool]()
        for part in self.parts:
            if isinstance(part, SumComparison):
                stack.append(waiting.pop(0))
            elif part == "not":
                stack.append(not stack.pop())
            else:
                one, other = stack.pop(), stack.pop()
                stack.append(one and other if part == "and" else one or other)
        return stack.pop()


def _is_met(comparison: SumComparison, total: float) -> bool:
    return total > 0.0 if comparison.is_strict else total >= 0.0


def _direction(comparison: SumComparison) -> tuple[tuple[tuple[Component, float], ...], float]:
    """Return a comparison's sum of signals as a multiple of one with the first factor 1."""
    factors = [(each, factor) for each, factor in comparison.factors.items() if factor]
    if not factors:
        return (), 1.0
    scale = factors[0][1]
    return tuple((each, factor / scale) for each, factor in factors), scale


def _around(key: Sequence[tuple[Component, float]], places: set[float]) -> list[float]:
    """Return values of a sum of signals at, beside and between places, as its types allow."""
    least, most = -math.inf, math.inf
    if len(key) == 1:
        name = key[0][0].resource.type.name
        least = 0.0 if name in _NOT_NEGATIVE else least
        most = 1.0 if name in _AT_MOST_ONE else most
    ends = sorted(places | ({least, most} - {math.inf, -math.inf}))
    between = [(one + other) / 2 for one, other in itertools.pairwise(ends)]
    values = [ends[0] - 1.0, *ends, *between, ends[-1] + 1.0]
    return [value for value in values if least <= value <= most]
