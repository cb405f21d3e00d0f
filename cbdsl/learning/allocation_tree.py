"""Allocation tree: the resources to try first in each context, learned from trials (Eq 5.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import add
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from cbdsl.learning.tree_growth import Outcomes, grow
from cbdsl.program.schema import Ranking
from cbdsl.types.decision_tree import Leaf, Split, Tree

# Evidence that a question needs, nats. A superfluous question costs little: its leaves choose the
# same allocation and are merged. A missing question costs all contexts on one side of it.
_NEEDED = -1.0


class TriedContext(NamedTuple):
    """Context with the allocations that were tried in it.

    Attributes:
        features: Features by name.
        outcomes: Whether each tried allocation was rewarded, in the order of the trials.
        counts: True if the trials are informative although none was rewarded.
    """

    features: Mapping[str, float]
    outcomes: Mapping[str, bool]
    counts: bool = False

    def first_alone(self) -> TriedContext:
        """Return the context with its first trial alone.

        Later trials find objects where the first one has left them.
        """
        return TriedContext(self.features, dict([*self.outcomes.items()][:1]), counts=True)

    @property
    def rewarded(self) -> bool:
        """Whether any allocation was rewarded."""
        return any(self.outcomes.values())


class Tally(NamedTuple):
    """Numbers of rewarded and unrewarded trials of each allocation in similar contexts.

    Attributes:
        successes, failures: Numbers in the order of the allocations' names.
    """

    successes: tuple[float, ...]
    failures: tuple[float, ...]

    def and_(self, other: Tally) -> Tally:
        """Return the sum of both tallies."""
        successes = map(add, self.successes, other.successes)
        failures = map(add, self.failures, other.failures)
        return Tally(tuple(successes), tuple(failures))

    def ranking(self, names: Sequence[str]) -> Ranking:
        """Return the allocations that were rewarded, the most promising first (Laplace's rule)."""
        some = [i for i, number in enumerate(self.successes) if number]
        return tuple(names[i] for i in sorted(some, key=lambda i: -self._chance(i)))

    def drawn(self, names: Sequence[str], rng: np.random.Generator) -> Ranking:
        """Return all allocations, ordered by chances that are drawn from their posteriors.

        Each allocation comes first as often as it is likely to be the best (Thompson, On the
        likelihood that
        one unknown probability exceeds another, 1933).
        """
        # Beta(h + 1, m + 1) is the posterior after h successes and m failures, with a uniform
        # prior.
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
    """Return the tree that groups similar contexts, with the tally of each group.

    If the first allocation that was tried is rewarded, the others are unknown: they count neither
    as rewarded nor as failed. A context without reward is ignored unless ``counts`` is set.

    Args:
        contexts: Contexts with trials.
        names: Names of all allocations.
        least: Fewest contexts of a leaf.
        resolutions: Differences that are insignificant, by feature.
    """
    kept = [each for each in contexts if each.rewarded or each.counts]
    if not kept:
        return Leaf(Tally((0.0,) * len(names), (0.0,) * len(names)))
    # An untried allocation has the outcome ``None``, which is neither ``True`` nor ``False``.
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
    """Return the tree of ranked allocations, without questions that only affect later ranks."""
    together = _joined(tree, names)
    if isinstance(together, Leaf):
        return Leaf(together.answer.ranking(names))
    parts = (rankings(part, names) for part in (together.above, together.below))
    return Split(together.feature, together.threshold, *parts)


def _joined(tree: Tree[Tally], names: Sequence[str]) -> Tree[Tally]:
    """Merge the leaves of a question that have the same first allocation."""
    if isinstance(tree, Leaf):
        return tree
    above, below = _joined(tree.above, names), _joined(tree.below, names)
    if isinstance(above, Leaf) and isinstance(below, Leaf):
        first, other = (leaf.answer.ranking(names)[:1] for leaf in (above, below))
        if first == other:
            return Leaf(above.answer.and_(below.answer))
    return Split(tree.feature, tree.threshold, above, below)
