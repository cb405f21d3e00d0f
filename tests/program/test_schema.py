"""Pr(reward | pi, f) is unknown where nothing was tried."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.program.schema import Schema
from cbdsl.types.decision_tree import Leaf, Split

TRIED = {"distance": (0.5, 1.5), "volume": (0.001, 0.002)}
SCHEMA = Schema("p", {}, {}, reward=Split("distance", 1.0, Leaf(0.02), Leaf(0.97)), tried=TRIED)
KNOWN = {"distance": 0.7, "volume": 0.0015}


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({}, 0.97),
        ({"distance": 1.2}, 0.02),
        ({"distance": 1.59}, 0.02),
        ({"distance": 1.7}, None),
        ({"distance": 0.3}, None),
        ({"volume": 0.01}, None),
        ({"volume": math.nan}, 0.97),
        ({"distance": math.nan}, None),
    ],
)
def test_reward_is_unknown_outside_of_all_tried_ranges(
    changed: dict[str, float], expected: float | None
) -> None:
    assert SCHEMA.reward_given(KNOWN | changed) == expected


@given(st.floats(0.5, 1.5), st.floats(0.001, 0.002))
def test_reward_is_known_within_all_tried_ranges(distance: float, volume: float) -> None:
    features = {"distance": distance, "volume": volume}
    assert SCHEMA.untried(features) == ()
    assert SCHEMA.reward_given(features) is not None


def test_reward_without_a_tree_is_unknown() -> None:
    assert SCHEMA._replace(reward=None).reward_given(KNOWN) is None


def test_reward_without_ranges_is_known_where_the_tree_decides() -> None:
    schema = SCHEMA._replace(tried={})
    assert schema.reward_given({"distance": 9.0}) == 0.02
    assert schema.reward_given({}) is None
