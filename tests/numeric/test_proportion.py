"""Exact intervals of proportions."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.numeric.proportion import exact_interval


def at_least(hits: int, trials: int, p: float) -> float:
    return sum(
        math.comb(trials, i) * p**i * (1 - p) ** (trials - i) for i in range(hits, trials + 1)
    )


@given(st.integers(1, 60).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_tails_at_the_ends_of_an_exact_interval_are_one_fortieth(case: tuple[int, int]) -> None:
    hits, trials = case
    low, high = exact_interval(hits, trials)
    assert 0 <= low <= hits / trials <= high <= 1
    if hits:
        assert at_least(hits, trials, low) == pytest.approx(0.025, abs=1e-6)
    if hits < trials:
        assert 1 - at_least(hits + 1, trials, high) == pytest.approx(0.025, abs=1e-6)


def test_exact_interval_of_100_of_100_begins_at_96_4_percent() -> None:
    assert exact_interval(100, 100) == pytest.approx((0.96378, 1.0), abs=1e-5)


@pytest.mark.parametrize(("hits", "trials"), [(0, 0), (-1, 5), (6, 5)])
def test_exact_interval_of_impossible_counts_is_refused(hits: int, trials: int) -> None:
    with pytest.raises(ValueError, match="not a proportion"):
        exact_interval(hits, trials)
