"""Relations are classified by their stiff directions, for every stiffness of the others."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.learning.catalogs.relation_tree import (
    NamedImpedance,
    grow_relations,
    larger_impedances,
    name_relation,
)
from cbdsl.learning.impedance import ImpedanceProfile, ImpedanceTest
from cbdsl.types.decision_tree import Leaf, Tree, splits
from cbdsl.types.direction import DIRECTIONS

STIFF = {
    "plane_on_plane": {"dPz", "dRx", "dRy"},
    "cylindrical": {"dPx", "dPy", "dRx", "dRy"},
    "prismatic": {"dPx", "dPy", "dRx", "dRy", "dRz"},
    "spherical": {"dPz"},
}


def felt(relation: str, rng: np.random.Generator, scale: float = 1.0) -> ImpedanceProfile:
    """Return a profile in which the relation's directions are 30 times as stiff, +/- half."""
    tests = []
    for name in DIRECTIONS:
        for sign in (1, -1):
            # Planes bear objects only from below.
            is_stiff = name in STIFF[relation] and (name != "dPz" or sign < 0)
            load = scale * (3.0 if is_stiff else 0.1) * rng.uniform(0.5, 1.5)
            tests.append(ImpedanceTest(name, sign, 0.01 * sign, load, is_stiff, 0.0, load))
    return ImpedanceProfile(tuple(tests))


def named(profile: ImpedanceProfile, relation: str) -> NamedImpedance:
    return NamedImpedance(larger_impedances(profile), relation)


def known(seed: int, count: int = 6) -> list[NamedImpedance]:
    rng = np.random.default_rng(seed)
    return [named(felt(name, rng), name) for name in STIFF for _ in range(count)]


def share(tree: Tree[str], seed: int) -> float:
    """Return the share of other profiles that a tree names right."""
    rng = np.random.default_rng(seed)
    right = [name_relation(tree, felt(name, rng)) == name for name in STIFF for _ in range(20)]
    return float(np.mean(right))


def test_tree_names_at_least_95_percent_of_other_profiles() -> None:
    assert share(grow_relations(known(1)), 2) >= 0.95


def test_names_without_information_give_no_question() -> None:
    rng = np.random.default_rng(3)
    mixed = [named(felt("spherical", rng), name) for name in STIFF for _ in range(6)]
    assert share(grow_relations(mixed), 4) <= 0.6


def test_profile_without_the_tests_asked_for_has_no_name() -> None:
    assert name_relation(grow_relations(known(1)), ImpedanceProfile(())) is None
    with pytest.raises(ValueError, match="whole profiles"):
        grow_relations([named(ImpedanceProfile(()), "spherical")])


def test_grow_relations_gives_thresholds_in_si_between_the_samples() -> None:
    samples = [*[("spherical", 0.02)] * 3, *[("plane_on_plane", 0.2)] * 3]
    own = [NamedImpedance({**dict.fromkeys(DIRECTIONS, 1.0), "dRz": z}, n) for n, z in samples]
    (question,) = splits(grow_relations(own))
    assert question.feature == "dRz"
    assert 0.02 < question.threshold < 0.2


def test_leaf_has_the_name_that_most_of_its_profiles_have() -> None:
    rng = np.random.default_rng(5)
    names = ["spherical", "prismatic", "prismatic"]
    mixed = [named(felt("spherical", rng), name) for name in names]
    assert grow_relations(mixed) == Leaf("prismatic")


def test_larger_impedances_leaves_out_directions_tested_in_one_sense() -> None:
    tests = (
        ImpedanceTest("dPx", 1, 0.01, 2.0, False, 0.0, 0.0),
        ImpedanceTest("dPx", -1, -0.01, -2.0, False, 0.0, -1.0),
        ImpedanceTest("dPy", 1, 0.01, 2.0, False, 0.0, 0.0),
        ImpedanceTest("dPy", -1, -0.01, 0.0, False, 0.0, 0.0),
        ImpedanceTest("dRz", 1, 0.1, 0.01, False, 0.0, 0.01),
    )
    expected = {"dPx": 100.0, "dPy": 0.0}
    assert larger_impedances(ImpedanceProfile(tests)) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(7, 12))
def test_relation_that_more_pairs_show_counts_as_much_as_the_others(seed: int) -> None:
    alike = known(seed)
    often = [each for each in alike if each.relation == "spherical"]
    assert grow_relations(alike + 4 * often) == grow_relations(alike)


def test_two_profiles_of_each_name_are_enough_for_a_question_and_one_is_not() -> None:
    two = [each for each in known(6, 2) if each.relation in ("prismatic", "spherical")]
    assert len(list(splits(grow_relations(two)))) == 1
    assert isinstance(grow_relations(two[1:3]), Leaf)
