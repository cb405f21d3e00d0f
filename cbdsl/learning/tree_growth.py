"""Growth of decision trees by information gain, as in C4.5 (Section 5.3.1.1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from cbdsl.types.decision_tree import Leaf, Split, Tree

Answer = TypeVar("Answer")
Label = TypeVar("Label", str, bool)

# Of thresholds: what lies beyond says nothing.
_DECIMALS = 4


def grow(
    samples: Sequence[Mapping[str, float]],
    labels: Sequence[Label],
    answer: Callable[[Counter[Label]], Answer],
    least: int,
) -> Tree[Answer]:
    """A tree whose splits gain the most information about a label.

    Args:
        samples: features by name, the same ones in each.
        labels: one a sample.
        answer: of a leaf, by the counts of the labels in it.
        least: fewest samples of a leaf.
    """
    names = tuple(samples[0]) if samples else ()
    if len(set(labels)) < 2 or not names:
        return Leaf(answer(Counter(labels)))
    from sklearn.tree import DecisionTreeClassifier  # a second to import, and needed here alone

    classifier = DecisionTreeClassifier(criterion="entropy", min_samples_leaf=least, random_state=0)
    numbers = np.array([[sample[name] for name in names] for sample in samples])
    # In the classifier numbers have single precision; ours have as many decimals as documents.
    classifier.fit(np.round(numbers, _DECIMALS), np.array([str(label) for label in labels]))
    return _pruned(_read(classifier.tree_, 0, names, numbers, list(labels), answer))


def _read(
    grown: Any,
    node: int,
    names: Sequence[str],
    numbers: np.ndarray[Any, np.dtype[np.float64]],
    labels: Sequence[Label],
    answer: Callable[[Counter[Label]], Answer],
) -> Tree[Answer]:
    """One node of a classifier's tree, and those below it."""
    if grown.children_left[node] < 0 or not labels:
        return Leaf(answer(Counter(labels)))
    feature, threshold = int(grown.feature[node]), round(float(grown.threshold[node]), _DECIMALS)
    above = numbers[:, feature] > threshold
    parts = [
        _read(
            grown,
            int(children[node]),
            names,
            numbers[side],
            [label for label, is_in in zip(labels, side, strict=True) if is_in],
            answer,
        )
        for children, side in ((grown.children_right, above), (grown.children_left, ~above))
    ]
    return Split(names[feature], threshold, parts[0], parts[1])


def _pruned(tree: Tree[Answer]) -> Tree[Answer]:
    """The same decisions without questions whose answers are equal."""
    if isinstance(tree, Leaf):
        return tree
    above, below = _pruned(tree.above), _pruned(tree.below)
    return above if above == below else Split(tree.feature, tree.threshold, above, below)
