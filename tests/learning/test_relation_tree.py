"""Relations are told by the directions that are stiff, however stiff the others are."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.learning.impedance import DIRECTIONS, ImpedanceProfile, ImpedanceTest
from cbdsl.learning.relation_tree import (
    NamedProfile,
    grow_relations,
    name_relation,
    tree_as_data,
)

STIFF = {
    "plane_on_plane": {"dPz", "dRx", "dRy"},
    "cylindrical": {"dPx", "dPy", "dRx", "dRy"},
    "prismatic": {"dPx", "dPy", "dRx", "dRy", "dRz"},
    "spherical": {"dPz"},
}


def felt(relation: str, rng: np.random.Generator, scale: float = 1.0) -> ImpedanceProfile:
    """A profile in which the relation's directions are 30 times as stiff, give or take half."""
    tests = []
    for name in DIRECTIONS:
        for sign in (1, -1):
            # Planes bear things from below alone.
            is_stiff = name in STIFF[relation] and (name != "dPz" or sign < 0)
            load = scale * (3.0 if is_stiff else 0.1) * rng.uniform(0.5, 1.5)
            tests.append(ImpedanceTest(name, sign, 0.01 * sign, load, is_stiff, 0.0))
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
