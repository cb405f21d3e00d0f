"""Names of relations between two objects, derived from their impedance (Section 7.2.3).

Each question tests the larger mean impedance of both senses of one direction. Questions are chosen
by the evidence of profiles with known relations. All relations have equal weight, independent of
their number of pairs. Impedances are compared by their logarithms, because a stiffer hand or a
heavier object shifts all of them alike.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.learning.impedance import DIRECTIONS, ImpedanceProfile
from cbdsl.learning.tree_growth import Outcomes, grow
from cbdsl.types.decision_tree import Leaf, Tree, decide

# Smallest impedance that counts, N/m or N m/rad.
_LEAST = 1e-2
# Fewest profiles of a leaf.
_PROFILES = 2


class NamedProfile(NamedTuple):
    """Profile with a known relation."""

    profile: ImpedanceProfile
    relation: str


def grow_relations(known: Sequence[NamedProfile]) -> Tree[str]:
    """Return the tree that explains profiles with known relations best.

    Raises:
        ValueError: If there is no profile, or one of them is incomplete.
    """
    if not known or not all(each.profile.is_whole for each in known):
        raise ValueError("relations are learned from whole profiles, one at least")
    names = sorted({each.relation for each in known})
    relations = [each.relation for each in known]
    numbers = Counter(relations)
    # Evidence needs integer weights.
    weights = np.array([[round(max(numbers.values()) / numbers[each])] for each in relations])
    is_named = np.array([[name == each for name in names] for each in relations])

    def most_frequent(rows: list[int]) -> str:
        return Counter(relations[row] for row in rows).most_common(1)[0][0]

    samples = [features(each.profile) for each in known]
    outcomes = Outcomes(1.0 * weights * is_named, 1.0 * weights * ~is_named)
    return grow(samples, outcomes, most_frequent, _PROFILES)


def name_relation(tree: Tree[str], profile: ImpedanceProfile) -> str | None:
    """Return the name of a profile's relation, or ``None`` if a required test is missing."""
    return decide(tree, features(profile))


def features(profile: ImpedanceProfile) -> Mapping[str, float]:
    """Return log10 of the impedances by direction, without directions tested in one sense only."""
    impedances = profile.features()
    return {
        direction: math.log10(max(impedances[f"{direction}+"], impedances[f"{direction}-"], _LEAST))
        for direction in DIRECTIONS
        if {f"{direction}+", f"{direction}-"} <= impedances.keys()
    }


def tree_as_data(tree: Tree[str]) -> object:
    """Return a tree for JSON or YAML, in the form of schemas."""
    if isinstance(tree, Leaf):
        return tree.answer
    return {
        "if": f"log10 {tree.feature} > {tree.threshold:g}",
        "then": tree_as_data(tree.above),
        "else": tree_as_data(tree.below),
    }
