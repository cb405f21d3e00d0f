"""Decision trees over numbers: one feature per split, and one answer per leaf."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Generic, NamedTuple, TypeVar

Answer = TypeVar("Answer")


class Leaf(NamedTuple, Generic[Answer]):
    """Leaf with an answer."""

    answer: Answer


class Split(NamedTuple, Generic[Answer]):
    """Split by the question whether a feature is larger than a threshold.

    Attributes:
        feature: Name of the feature.
        threshold: Threshold in SI units.
        above: Subtree for values above the threshold.
        below: Subtree for all other values.
    """

    feature: str
    threshold: float
    above: Tree[Answer]
    below: Tree[Answer]


Tree = Leaf[Answer] | Split[Answer]


def decide(tree: Tree[Answer], features: Mapping[str, float]) -> Answer | None:
    """Return the answer of a tree, or ``None`` if a required feature is unknown or NaN."""
    while isinstance(tree, Split):
        value = features.get(tree.feature, math.nan)
        # NaN is not larger than any threshold, and would silently choose the branch ``below``.
        if math.isnan(value):
            return None
        tree = tree.above if value > tree.threshold else tree.below
    return tree.answer


def splits(tree: Tree[Answer]) -> Iterator[Split[Answer]]:
    """Yield all splits of a tree, from its root downwards."""
    if isinstance(tree, Split):
        yield tree
        yield from splits(tree.above)
        yield from splits(tree.below)


def leaves(tree: Tree[Answer]) -> Iterator[Answer]:
    """Yield all answers of a tree, answers above a threshold first."""
    if isinstance(tree, Split):
        yield from leaves(tree.above)
        yield from leaves(tree.below)
    else:
        yield tree.answer
