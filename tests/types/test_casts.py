"""The cast graph."""

from __future__ import annotations

from itertools import product

import pytest

from cbdsl.types.casts import CASTS, FEATURES, chains
from cbdsl.types.resource_type import FORCE, HEADING, POSE, POSITION, TYPES, configuration


@pytest.mark.parametrize(("start", "goal"), list(product(TYPES, TYPES)))
def test_no_chain_is_ambiguous_and_every_chain_connects(start: str, goal: str) -> None:
    found = chains(TYPES[start], TYPES[goal])
    assert len(found) <= 1
    for chain in found:
        at = start
        for cast in chain:
            assert cast.source == at
            at = cast.target
        assert at == goal


@pytest.mark.parametrize("name", TYPES)
def test_every_type_but_of_features_leads_to_a_configuration(name: str) -> None:
    assert bool(chains(TYPES[name], configuration(7))) == (name not in FEATURES)


def test_only_a_force_has_a_chain_to_a_force() -> None:
    assert [kind for kind in TYPES if chains(TYPES[kind], FORCE)] == ["force"]


def test_triangulation_takes_two_headings() -> None:
    (both,) = chains(HEADING.times(2), POSITION)
    assert [cast.name for cast in both] == ["stereo triangulation"]
    (one,) = chains(HEADING, POSITION)
    assert "stereo triangulation" not in [cast.name for cast in one]


def test_equal_types_need_no_cast() -> None:
    assert chains(POSE, POSE) == ((),)
    assert chains(FORCE.times(3), FORCE) == ((),)


def test_casts_are_between_types() -> None:
    assert {name for cast in CASTS for name in (cast.source, cast.target)} <= set(TYPES)
