"""Epsilon-greedy choice is fair among the best, and among all."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.learning.accommodate import choose

ACTIONS = ("a", "b", "c", "d")


@given(st.sets(st.sampled_from(ACTIONS), min_size=1), st.integers(0, 2**32))
def test_epsilon_zero_chooses_only_best_actions(best: set[str], seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert {choose(sorted(best), ACTIONS, 0.0, rng) for _ in range(20)} <= best


@pytest.mark.parametrize("epsilon", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("best", [("b",), ("b", "d"), ACTIONS])
def test_shares_of_actions_follow_epsilon(epsilon: float, best: tuple[str, ...]) -> None:
    rng, count = np.random.default_rng(7), 8000
    found = Counter(choose(best, ACTIONS, epsilon, rng) for _ in range(count))
    for action in ACTIONS:
        share = epsilon / len(ACTIONS) + (action in best) * (1 - epsilon) / len(best)
        assert found[action] / count == pytest.approx(share, abs=0.02)
