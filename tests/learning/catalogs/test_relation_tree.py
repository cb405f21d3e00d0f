"""Relations are classified by their stiff directions, for every stiffness of the others."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.learning.catalogs.relation_tree import (
    NamedProfile,
    features,
    grow_relations,
    name_relation,
    tree_as_data,
)
from cbdsl.learning.impedance import DIRECTIONS, ImpedanceProfile, ImpedanceTest
from cbdsl.types.decision_tree import Leaf, splits

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


def known(seed: int, count: int = 6) -> list[NamedProfile]:
    rng = np.random.default_rng(seed)
    return [NamedProfile(felt(name, rng), name) for name in STIFF for _ in range(count)]


def test_other_profiles_are_named() -> None:
    tree = grow_relations(known(1))
    others = known(2, 20)
    named = [name_relation(tree, each.profile) == each.relation for each in others]
    assert np.mean(named) >= 0.95


def test_names_that_say_nothing_are_not_learned() -> None:
    rng = np.random.default_rng(3)
    mixed = [NamedProfile(felt("spherical", rng), name) for name in STIFF for _ in range(6)]
    others = known(4, 20)
    tree = grow_relations(mixed)
    named = [name_relation(tree, each.profile) == each.relation for each in others]
    assert np.mean(named) <= 0.6


def test_a_profile_without_the_tests_asked_for_has_no_name() -> None:
    assert name_relation(grow_relations(known(1)), ImpedanceProfile(())) is None
    with pytest.raises(ValueError, match="whole profiles"):
        grow_relations([NamedProfile(ImpedanceProfile(()), "spherical")])


def test_a_tree_is_written_as_schemas_write_theirs() -> None:
    data = tree_as_data(grow_relations(known(1)))
    assert isinstance(data, dict) and set(data) == {"if", "then", "else"}
    assert str(data["if"]).startswith("log10 d")


def test_a_leaf_has_the_name_that_most_of_its_profiles_have() -> None:
    rng = np.random.default_rng(5)
    names = ["spherical", "prismatic", "prismatic"]
    mixed = [NamedProfile(felt("spherical", rng), name) for name in names]
    assert grow_relations(mixed) == Leaf("prismatic")


def test_impedances_are_the_larger_ones_of_both_ways_and_nothing_is_as_little_as_can_be_told() -> (
    None
):
    tests = (
        ImpedanceTest("dPx", 1, 0.01, 2.0, False, 0.0, 0.0),
        ImpedanceTest("dPx", -1, -0.01, -2.0, False, 0.0, -1.0),
        ImpedanceTest("dPy", 1, 0.01, 2.0, False, 0.0, 0.0),
        ImpedanceTest("dPy", -1, -0.01, 0.0, False, 0.0, 0.0),
        ImpedanceTest("dRz", 1, 0.1, 0.01, False, 0.0, 0.01),
    )
    assert features(ImpedanceProfile(tests)) == pytest.approx({"dPx": 2, "dPy": -2})


@pytest.mark.parametrize("seed", range(7, 12))
def test_a_relation_that_more_pairs_show_counts_as_much_as_the_others(seed: int) -> None:
    alike = known(seed)
    often = [each for each in alike if each.relation == "spherical"]
    assert grow_relations(alike + 4 * often) == grow_relations(alike)


def test_two_profiles_of_each_name_are_enough_for_a_question_and_one_is_not() -> None:
    two = [each for each in known(6, 2) if each.relation in ("prismatic", "spherical")]
    assert len(list(splits(grow_relations(two)))) == 1
    assert isinstance(grow_relations(two[1:3]), Leaf)
