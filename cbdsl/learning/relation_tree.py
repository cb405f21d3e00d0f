"""Names of relations between two things, told from their impedance (Section 7.2.3).

The tree asks for the mean impedance of one direction each, of both ways the larger one, by evidence
of profiles whose relations are known. All relations count alike, however many pairs show them.
Impedances are compared by their logarithms: a hand that is twice as stiff, or a thing that is twice
as heavy, shifts all of them alike.
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

# Less than that, N/m or N m/rad, is no impedance.
_LEAST = 1e-2
# Fewest profiles that a leaf stands for.
_PROFILES = 2


class NamedProfile(NamedTuple):
    """A profile whose relation is known."""

    profile: ImpedanceProfile
    relation: str


def grow_relations(known: Sequence[NamedProfile]) -> Tree[str]:
    """The tree that profiles with known relations speak for.

    Raises:
        ValueError: there is no profile, or one of them is not whole.
    """
    if not known or not all(each.profile.is_whole for each in known):
        raise ValueError("relations are learned from whole profiles, one at least")
    names = sorted({each.relation for each in known})
    relations = [each.relation for each in known]
    numbers = Counter(relations)
    # Whole numbers, as evidence counts.
    weights = np.array([[round(max(numbers.values()) / numbers[each])] for each in relations])
    is_named = np.array([[name == each for name in names] for each in relations])

    def most_frequent(rows: list[int]) -> str:
        return Counter(relations[row] for row in rows).most_common(1)[0][0]

    samples = [features(each.profile) for each in known]
    outcomes = Outcomes(1.0 * weights * is_named, 1.0 * weights * ~is_named)
    return grow(samples, outcomes, most_frequent, _PROFILES)


def name_relation(tree: Tree[str], profile: ImpedanceProfile) -> str | None:
    """The name of a profile's relation; ``None`` where a test that the tree asks for is missing."""
    return decide(tree, features(profile))


def features(profile: ImpedanceProfile) -> Mapping[str, float]:
    """Decimal logarithms of the impedances by direction; what was tested one way is left out."""
    impedances = profile.features()
    return {
        direction: math.log10(max(impedances[f"{direction}+"], impedances[f"{direction}-"], _LEAST))
        for direction in DIRECTIONS
        if {f"{direction}+", f"{direction}-"} <= impedances.keys()
    }


def tree_as_data(tree: Tree[str]) -> object:
    """A tree for JSON or YAML, as schemas write theirs."""
    if isinstance(tree, Leaf):
        return tree.answer
    return {
        "if": f"log10 {tree.feature} > {tree.threshold:g}",
        "then": tree_as_data(tree.above),
        "else": tree_as_data(tree.below),
    }
