"""Growth of decision trees by the evidence for their questions (Section 5.3.1.1).

A tree predicts which trials succeed. In a leaf, the success probability of each kind of trial has a
uniform prior. The threshold of a question has a uniform prior between the least and the largest
value of its feature. The evidence for a question is the log probability of all outcomes with it,
minus that without it (Buntine, Learning classification trees, 1992). With many samples this is the
information gain of C4.5. With few samples, it prefers thresholds in wide gaps to thresholds that
isolate single samples. There is no gap between neighbours within the measurement resolution, nor
between groups of samples whose means differ by less than twice of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Floats
from cbdsl.types.decision_tree import Leaf, Split, Tree

Answer = TypeVar("Answer")

# Decimals of thresholds; further ones are not significant.
_DECIMALS = 4
# Rounding errors of evidence, nats, and of differences.
_NOTHING = _ROUNDING = 1e-9


class Outcomes(NamedTuple):
    """Numbers of successful and failed trials of several kinds; untried ones are in neither.

    Attributes:
        successes, failures: Counts, shape (samples, kinds), or (kinds,) for their sums.
    """

    successes: Floats
    failures: Floats

    def of(self, rows: NDArray[np.intp] | int) -> Outcomes:
        """Return the outcomes of some samples or of one."""
        return Outcomes(self.successes[rows], self.failures[rows])

    @property
    def sums(self) -> Outcomes:
        """Sums over the samples, by kind."""
        return Outcomes(self.successes.sum(axis=0), self.failures.sum(axis=0))


class _Question(NamedTuple):
    feature: int
    threshold: float


def grow(
    samples: Sequence[Mapping[str, float]],
    outcomes: Outcomes,
    answer: Callable[[list[int]], Answer],
    least: int,
    resolutions: Mapping[str, float] = MappingProxyType({}),
    trust: float = 0.5,
    needed: float = 0.0,
) -> Tree[Answer]:
    """Return the tree whose questions are supported by the outcomes.

    Args:
        samples: Features by name, the same names in each sample.
        outcomes: Outcomes of the trials in each sample.
        answer: Function from the indices of the samples in a leaf to its answer.
        least: Fewest samples of a leaf.
        resolutions: Insignificant differences, by feature; 0 for features without an entry.
        trust: Share of the gap without samples at a threshold that goes to the side with the higher
            success rate.
        needed: Evidence that a question needs, nats.
    """
    # With the sums h of successes and m of failures of each kind, the evidence in nats is
    #     L of the samples below + L of those above - L of both + ln(gap / range),
    #     L = sum over kinds of ln(h! m! / (h + m + 1)!).
    # L is the logarithm of the integral of p^h (1 - p)^m over the success probability p from 0 to
    # 1. The quotient gap / range is the prior probability that the threshold lies in this gap.
    names = tuple(next(iter(samples), ()))
    numbers = np.array([[sample[name] for name in names] for sample in samples])
    numbers = np.round(numbers.reshape(len(samples), len(names)), _DECIMALS)
    finest = np.array([resolutions.get(name, 0.0) for name in names])

    def node(rows: NDArray[np.intp]) -> Tree[Answer]:
        question = _best(numbers[rows], outcomes.of(rows), least, finest, trust, needed)
        if question is None:
            return Leaf(answer(rows.tolist()))
        above = numbers[rows, question.feature] > question.threshold
        name, threshold = names[question.feature], question.threshold
        return Split(name, threshold, node(rows[above]), node(rows[~above]))

    return _pruned(node(np.arange(len(samples))))


def _best(
    numbers: Floats, outcomes: Outcomes, least: int, finest: Floats, trust: float, needed: float
) -> _Question | None:
    """Return the question with the most evidence; ties go to the first feature, lowest threshold.

    Args:
        numbers: Values of the features, shape (samples, features).
        outcomes: Outcomes of the samples.
        least: Fewest samples of a leaf.
        finest: Insignificant differences of each feature, shape (features,).
        trust: Share of a gap, see ``grow``.
        needed: Evidence that a question needs, see ``grow``.
    """
    best: _Question | None = None
    least_evidence = needed + _NOTHING
    now = _evidence(outcomes.sums)
    for feature in range(numbers.shape[1]):
        order = np.argsort(numbers[:, feature], kind="stable")
        values = numbers[order, feature]
        cuts = np.arange(least, len(values) - least + 1)
        cuts, wide = _gaps(values, cuts, float(finest[feature]))
        # A feature with one value has no gap, so that its range of 0 is never a divisor.
        if not len(cuts):
            continue
        sums = Outcomes(*(np.cumsum(each, axis=0) for each in outcomes.of(order)))
        below = sums.of(cuts - 1)
        above = Outcomes(*(all_[-1] - some for all_, some in zip(sums, below, strict=True)))
        gaps = np.log(wide / (values[-1] - values[0]))
        evidence = _evidence(below) + _evidence(above) - now + gaps
        place = int(np.argmax(evidence))
        if evidence[place] > least_evidence:
            least_evidence = evidence[place] + _NOTHING
            share = trust if _rate(below.of(place)) >= _rate(above.of(place)) else 1.0 - trust
            low, high = values[cuts[place] - 1], values[cuts[place]]
            best = _Question(feature, _threshold(float(low), float(high), share))
    return best


def _gaps(values: Floats, cuts: NDArray[np.intp], finest: float) -> tuple[Any, Floats]:
    """Return the cuts between values that a measurement distinguishes, and their widths.

    Neighbours differ by the resolution at least. The means of both sides differ by twice of it, so
    that a feature that only varies by its noise is never asked for. A dense sample of a wide range
    keeps all its cuts.

    Args:
        values: Sorted values of one feature, shape (samples,).
        cuts: Numbers of the values below each cut, shape (k,).
        finest: Resolution of the feature.
    """
    wide = values[cuts] - values[cuts - 1]
    sums = np.cumsum(values)[cuts - 1]
    apart = (values.sum() - sums) / (len(values) - cuts) - sums / cuts
    is_gap = wide > max(finest - _ROUNDING, _ROUNDING)
    is_gap &= apart > 2 * finest - _ROUNDING
    return cuts[is_gap], wide[is_gap]


def _rate(sums: Outcomes) -> float:
    """Return the share of successful trials, of all kinds together."""
    successes, failures = (float(each.sum()) for each in sums)
    return successes / (successes + failures) if successes + failures else 0.5


def _threshold(low: float, high: float, share: float) -> float:
    """Return a rounded number in a gap, ``share`` of the way from its lower end."""
    # Rounding can reach the upper value, which then does not lie above the threshold.
    between = round((1.0 - share) * low + share * high, _DECIMALS)
    return between if low <= between < high else low


def _evidence(sums: Outcomes) -> Any:
    """Return the log probability of outcomes under uniform priors, shape (...)."""
    successes, failures = (_log_factorial(each) for each in sums)
    together = _log_factorial(sums.successes + sums.failures + 1)
    return (successes + failures - together).sum(axis=-1)


def _log_factorial(numbers: Floats) -> Floats:
    whole = numbers.astype(np.intp)
    table = np.array([math.lgamma(n + 1) for n in range(int(whole.max(initial=0)) + 1)])
    logarithms: Floats = table[whole]
    return logarithms


def _pruned(tree: Tree[Answer]) -> Tree[Answer]:
    """Return the tree without questions whose answers are equal."""
    if isinstance(tree, Leaf):
        return tree
    above, below = _pruned(tree.above), _pruned(tree.below)
    return above if above == below else Split(tree.feature, tree.threshold, above, below)
