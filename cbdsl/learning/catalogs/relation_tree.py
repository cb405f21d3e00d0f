"""Names of relations between two objects, derived from their impedance (Section 7.2.3).

Each question tests the larger mean impedance of both senses of one direction. Questions are chosen
by the evidence of profiles with known relations. All relations have equal weight, independent of
their number of profiles. Impedances are compared by their logarithms, because a stiffer hand or a
heavier object shifts all of them alike.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.learning.impedance import ImpedanceProfile
from cbdsl.learning.tree_growth import Outcomes, grow
from cbdsl.types.decision_tree import Leaf, Split, Tree, decide
from cbdsl.types.direction import DIRECTIONS

# Smallest impedance that counts, N/m or N m/rad.
_LEAST = 1e-2
# Significant digits of thresholds.
_DIGITS = 3


class NamedImpedance(NamedTuple):
    """Impedance of two objects with a known relation.

    Attributes:
        impedances: Impedance by direction, N/m or N m/rad; all directions.
        relation: Name of the relation.
    """

    impedances: Mapping[str, float]
    relation: str


def grow_relations(known: Sequence[NamedImpedance], least: int = 2) -> Tree[str]:
    """Return the tree that explains impedances with known relations best.

    Args:
        known: Impedances with known relations.
        least: Fewest of them in a leaf.

    Raises:
        ValueError: If there is none, or one of them lacks a direction.
    """
    if not known or not all({*DIRECTIONS} <= each.impedances.keys() for each in known):
        raise ValueError("relations are learned from whole profiles, one at least")
    names = sorted({each.relation for each in known})
    relations = [each.relation for each in known]
    numbers = Counter(relations)
    # Evidence needs integer weights.
    weights = np.array([[round(max(numbers.values()) / numbers[each])] for each in relations])
    is_named = np.array([[name == each for name in names] for each in relations])

    def most_frequent(rows: list[int]) -> str:
        return Counter(relations[row] for row in rows).most_common(1)[0][0]

    samples = [
        {name: math.log10(max(each.impedances[name], _LEAST)) for name in DIRECTIONS}
        for each in known
    ]
    outcomes = Outcomes(1.0 * weights * is_named, 1.0 * weights * ~is_named)
    return _in_si(grow(samples, outcomes, most_frequent, least))


def name_relation(tree: Tree[str], profile: ImpedanceProfile) -> str | None:
    """Return the name of a profile's relation, or ``None`` if a required test is missing."""
    return decide(tree, larger_impedances(profile))


def larger_impedances(profile: ImpedanceProfile) -> dict[str, float]:
    """Return the larger mean impedance of both senses, without directions tested in one only."""
    impedances = profile.features()
    return {
        direction: max(impedances[f"{direction}+"], impedances[f"{direction}-"])
        for direction in DIRECTIONS
        if {f"{direction}+", f"{direction}-"} <= impedances.keys()
    }


def _in_si(tree: Tree[str]) -> Tree[str]:
    """Return a tree over logarithms as a tree over the impedances themselves."""
    if isinstance(tree, Leaf):
        return tree
    threshold = float(f"{10.0**tree.threshold:.{_DIGITS}g}")
    return Split(tree.feature, threshold, _in_si(tree.above), _in_si(tree.below))
