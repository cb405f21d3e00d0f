"""Allocation tree: which resources to try first in which context, from what was tried (Eq 5.4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.learning.tree_growth import grow
from cbdsl.program.schema import Ranking
from cbdsl.types.decision_tree import Leaf, Split, Tree, decide

Floats = NDArray[np.float64]

# What an allocation that was not tried counts for at first, of what one that was rewarded does.
_UNTRIED = 0.3
_ROUNDS = 3


class TriedContext(NamedTuple):
    """A context, and the allocations that were tried in it.

    Attributes:
        features: by name.
        outcomes: whether each that was tried was rewarded.
    """

    features: Mapping[str, float]
    outcomes: Mapping[str, bool]

    @property
    def rewarded(self) -> bool:
        """Whether any was."""
        return any(self.outcomes.values())


def grow_choice(
    contexts: Sequence[TriedContext], names: Sequence[str], least: int
) -> Tree[Ranking]:
    """The tree of allocations that were rewarded, or would have been.

    Where the first one that was tried is rewarded, nobody knows of the others: taken for failures,
    they would let a tree tell apart what any of them can do, by chance. They count for as much as
    in similar contexts, which the tree itself has together; it is grown a few times over.

    Args:
        contexts: in which something was tried.
        names: of all allocations.
        least: fewest contexts of a leaf.
    """
    kept = [each for each in contexts if each.rewarded]
    if not kept:
        return Leaf(())
    samples = [each.features for each in kept]
    outcomes = np.array([[_share(each.outcomes.get(name)) for name in names] for each in kept])
    untried = np.array([[name not in each.outcomes for name in names] for each in kept])
    shares = _normalised(outcomes)
    for _ in range(_ROUNDS):
        tree = grow(samples, shares, partial(_mean, shares), least)
        similar = np.array([decide(tree, sample) for sample in samples])
        shares = _normalised(np.where(untried, similar, outcomes))

    # Questions that only tell which one to try second are left out.
    first = grow(samples, shares, lambda rows: int(shares[rows].sum(axis=0).argmax()), least)

    def ranking(rows: list[int]) -> Ranking:
        worth, rewarded = shares[rows].sum(axis=0), (outcomes[rows] == 1.0).any(axis=0)
        return tuple(names[i] for i in np.argsort(-worth, kind="stable") if rewarded[i])

    return _answered(first, samples, list(range(len(samples))), ranking)


def _answered(
    tree: Tree[int],
    samples: Sequence[Mapping[str, float]],
    rows: list[int],
    answer: Callable[[list[int]], Ranking],
) -> Tree[Ranking]:
    """The same questions, with answers by the samples in each leaf."""
    if isinstance(tree, Leaf):
        return Leaf(answer(rows))
    above = [row for row in rows if samples[row][tree.feature] > tree.threshold]
    below = [row for row in rows if samples[row][tree.feature] <= tree.threshold]
    parts = (
        _answered(part, samples, some, answer)
        for part, some in ((tree.above, above), (tree.below, below))
    )
    return Split(tree.feature, tree.threshold, *parts)


def _share(rewarded: bool | None) -> float:
    return _UNTRIED if rewarded is None else float(rewarded)


def _normalised(shares: Floats) -> Floats:
    normalised: Floats = shares / shares.sum(axis=1, keepdims=True)
    return normalised


def _mean(shares: Floats, rows: list[int]) -> tuple[float, ...]:
    """Mean shares of the labels in some samples."""
    return tuple(shares[rows].mean(axis=0).tolist())
