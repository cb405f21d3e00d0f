"""Growth of decision trees by information gain, as in C4.5 (Section 5.3.1.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from cbdsl.types.decision_tree import Leaf, Split, Tree

Answer = TypeVar("Answer")
Floats = NDArray[np.float64]

# Of thresholds: what lies beyond says nothing.
_DECIMALS = 4
# A gain that is rounding alone, bits.
_NOTHING = 1e-9


class _Question(NamedTuple):
    gain: float
    feature: int
    threshold: float


def grow(
    samples: Sequence[Mapping[str, float]],
    shares: Floats,
    answer: Callable[[list[int]], Answer],
    least: int,
    *,
    frugal: bool = False,
) -> Tree[Answer]:
    """A tree whose questions gain the most information about a label.

    Args:
        samples: features by name, the same ones in each.
        shares: of each label in each sample, shape (samples, labels); one and zeros where the
            label is certain.
        answer: of a leaf, by the indices of the samples in it.
        least: fewest samples of a leaf.
        frugal: whether a question has to gain more than it takes to tell its threshold (Quinlan,
            Improved use of continuous attributes in C4.5, 1996).
    """
    names = tuple(samples[0]) if samples else ()
    numbers = np.array([[sample[name] for name in names] for sample in samples])
    numbers = np.round(numbers.reshape(len(samples), len(names)), _DECIMALS)

    def node(rows: NDArray[np.intp]) -> Tree[Answer]:
        question = _best(numbers[rows], shares[rows], least, frugal=frugal)
        if question is None:
            return Leaf(answer(rows.tolist()))
        above = numbers[rows, question.feature] > question.threshold
        name, threshold = names[question.feature], question.threshold
        return Split(name, threshold, node(rows[above]), node(rows[~above]))

    return _pruned(node(np.arange(len(samples))))


def _best(numbers: Floats, shares: Floats, least: int, *, frugal: bool) -> _Question | None:
    """The question that gains the most; of equal ones that of the first feature, the lowest."""
    best = _Question(_NOTHING, 0, 0.0)
    now = _information(shares.sum(axis=0))
    for feature in range(numbers.shape[1]):
        order = np.argsort(numbers[:, feature], kind="stable")
        values, sums = numbers[order, feature], np.cumsum(shares[order], axis=0)
        cuts = np.arange(least, len(values) - least + 1)
        cuts = cuts[values[cuts - 1] < values[cuts]] if len(cuts) else cuts
        if not len(cuts):
            continue
        gains = now - _information(sums[cuts - 1]) - _information(sums[-1] - sums[cuts - 1])
        gains = gains - np.log2(len(cuts)) if frugal else gains
        place = int(np.argmax(gains))
        if gains[place] > best.gain + _NOTHING:
            below, above = values[cuts[place] - 1], values[cuts[place]]
            middle = round(float(below + above) / 2, _DECIMALS)
            threshold = middle if below <= middle < above else float(below)
            best = _Question(float(gains[place]), feature, threshold)
    return best if best.gain > _NOTHING else None


def _information(shares: Floats) -> Any:
    """Bits that tell the labels of samples, by the sums of their shares, shape (..., labels)."""
    total = shares.sum(axis=-1, keepdims=True)
    known = shares > 0.0
    relative = np.where(known, shares, 1.0) / np.where(known, total, 1.0)
    return -(shares * np.log2(relative)).sum(axis=-1)


def _pruned(tree: Tree[Answer]) -> Tree[Answer]:
    """The same decisions without questions whose answers are equal."""
    if isinstance(tree, Leaf):
        return tree
    above, below = _pruned(tree.above), _pruned(tree.below)
    return above if above == below else Split(tree.feature, tree.threshold, above, below)
