"""Allocation tree: which resources to try first in which context, from what was tried (Eq 5.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import add
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from cbdsl.learning.tree_growth import Outcomes, grow
from cbdsl.program.schema import Ranking
from cbdsl.types.decision_tree import Leaf, Split, Tree

# Evidence that a question needs, nats. One that is asked in vain costs little: its leaves choose
# the same, and become one again; one that is not asked costs all contexts on one side of it.
_NEEDED = -1.0


class TriedContext(NamedTuple):
    """A context, and the allocations that were tried in it.

    Attributes:
        features: by name.
        outcomes: whether each that was tried was rewarded, in their order.
        counts: whether what was tried tells something although none was rewarded.
    """

    features: Mapping[str, float]
    outcomes: Mapping[str, bool]
    counts: bool = False

    def first_alone(self) -> TriedContext:
        """The same with the first that was tried, as far as it could have done: later ones find
        things where it has left them.
        """
        return TriedContext(self.features, dict([*self.outcomes.items()][:1]), counts=True)

    @property
    def rewarded(self) -> bool:
        """Whether any was."""
        return any(self.outcomes.values())


class Tally(NamedTuple):
    """How often each allocation was rewarded in similar contexts, and how often not.

    Attributes:
        successes, failures: in the order of their names.
    """

    successes: tuple[float, ...]
    failures: tuple[float, ...]

    def and_(self, other: Tally) -> Tally:
        """Both together."""
        successes = map(add, self.successes, other.successes)
        failures = map(add, self.failures, other.failures)
        return Tally(tuple(successes), tuple(failures))

    def ranking(self, names: Sequence[str]) -> Ranking:
        """Those that were rewarded, the most promising one first (Laplace's rule)."""
        some = [i for i, number in enumerate(self.successes) if number]
        return tuple(names[i] for i in sorted(some, key=lambda i: -self._chance(i)))

    def drawn(self, names: Sequence[str], rng: np.random.Generator) -> Ranking:
        """All of them, by chances that are drawn from what is known of each.

        Each comes first as often as it is likely to be the best (Thompson, On the likelihood that
        one unknown probability exceeds another, 1933).
        """
        chances = rng.beta(np.add(self.successes, 1.0), np.add(self.failures, 1.0))
        return tuple(names[i] for i in np.argsort(-chances, kind="stable"))

    def _chance(self, i: int) -> float:
        return (self.successes[i] + 1.0) / (self.successes[i] + self.failures[i] + 2.0)


def grow_tallies(
    contexts: Sequence[TriedContext],
    names: Sequence[str],
    least: int,
    resolutions: Mapping[str, float] = MappingProxyType({}),
) -> Tree[Tally]:
    """The tree that has similar contexts together, with what was tried in them.

    Where the first allocation that was tried is rewarded, nobody knows of the others: they count
    neither as rewarded nor as failed. Where none was, none can be preferred, unless the context
    counts all the same.

    Args:
        contexts: in which something was tried.
        names: of all allocations.
        least: fewest contexts of a leaf.
        resolutions: by feature, differences that are none.
    """
    kept = [each for each in contexts if each.rewarded or each.counts]
    if not kept:
        return Leaf(Tally((0.0,) * len(names), (0.0,) * len(names)))
    counts = (
        np.array([[float(each.outcomes.get(name) is came) for name in names] for each in kept])
        for came in (True, False)
    )
    outcomes = Outcomes(*counts)

    def tally(rows: list[int]) -> Tally:
        sums = outcomes.of(np.array(rows)).sums
        return Tally(*(tuple(each.tolist()) for each in sums))

    features = [each.features for each in kept]
    return grow(features, outcomes, tally, least, resolutions, needed=_NEEDED)


def rankings(tree: Tree[Tally], names: Sequence[str]) -> Tree[Ranking]:
    """The same tree with the allocations to try, without what only tells which to try second."""
    together = _joined(tree, names)
    if isinstance(together, Leaf):
        return Leaf(together.answer.ranking(names))
    parts = (rankings(part, names) for part in (together.above, together.below))
    return Split(together.feature, together.threshold, *parts)


def _joined(tree: Tree[Tally], names: Sequence[str]) -> Tree[Tally]:
    """Leaves of one question with the same first allocation as one."""
    if isinstance(tree, Leaf):
        return tree
    above, below = _joined(tree.above, names), _joined(tree.below, names)
    if isinstance(above, Leaf) and isinstance(below, Leaf):
        first, other = (leaf.answer.ranking(names)[:1] for leaf in (above, below))
        if first == other:
            return Leaf(above.answer.and_(below.answer))
    return Split(tree.feature, tree.threshold, above, below)
