"""Decision trees over numbers: questions about one feature each, and an answer at every leaf."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Generic, NamedTuple, TypeVar

Answer = TypeVar("Answer")


class Leaf(NamedTuple, Generic[Answer]):
    """An answer."""

    answer: Answer


class Split(NamedTuple, Generic[Answer]):
    """A question: whether a feature is larger than a threshold.

    Attributes:
        feature: its name.
        threshold: in SI.
        above: the tree where it is.
        below: the tree where it is not.
    """

    feature: str
    threshold: float
    above: Tree[Answer]
    below: Tree[Answer]


Tree = Leaf[Answer] | Split[Answer]


def decide(tree: Tree[Answer], features: Mapping[str, float]) -> Answer | None:
    """The answer of a tree; ``None`` where it asks for a feature that is not known, or NaN."""
    while isinstance(tree, Split):
        value = features.get(tree.feature, math.nan)
        if math.isnan(value):
            return None
        tree = tree.above if value > tree.threshold else tree.below
    return tree.answer


def splits(tree: Tree[Answer]) -> Iterator[Split[Answer]]:
    """All questions of a tree, from its root downwards."""
    if isinstance(tree, Split):
        yield tree
        yield from splits(tree.above)
        yield from splits(tree.below)


def leaves(tree: Tree[Answer]) -> Iterator[Answer]:
    """All answers of a tree, those above a threshold first."""
    if isinstance(tree, Split):
        yield from leaves(tree.above)
        yield from leaves(tree.below)
    else:
        yield tree.answer
