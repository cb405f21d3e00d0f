"""Comparisons: exact intervals that hold at any stop, and pairs with the same seeds."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl_compare.comparison import ProgramComparison, compare, difference_interval, is_open


def test_difference_interval_is_decided_by_nine_pairs_in_one_direction() -> None:
    assert difference_interval(0, 8, 8)[0] < 0.0 < difference_interval(0, 9, 9)[0]
    assert difference_interval(9, 0, 9)[1] < 0.0


@pytest.mark.parametrize("counts", [(0, 0, 0), (0, 0, 5), (3, 7, 40), (40, 2, 60)])
def test_difference_interval_holds_the_difference_and_mirrors(
    counts: tuple[int, int, int],
) -> None:
    first, second, pairs = counts
    low, high = difference_interval(first, second, pairs)
    assert -1.0 <= low <= (second - first) / max(pairs, 1) <= high <= 1.0
    assert difference_interval(second, first, pairs) == pytest.approx((-high, -low), abs=1e-9)


def test_difference_interval_errs_seldom_although_comparisons_stop_early() -> None:
    rng, wrong = np.random.default_rng(0), 0
    for _ in range(60):
        draws, counts = rng.random(80), [0, 0]
        for pairs, draw in enumerate(draws, 1):
            if draw < 0.6:
                counts[int(draw < 0.3)] += 1
            if sum(counts) < 9:
                continue
            low, high = difference_interval(counts[0], counts[1], pairs)
            if low > 0.0 or high < 0.0:
                wrong += 1
                break
    assert wrong <= 6


def test_is_open_ends_when_no_remaining_pair_can_decide() -> None:
    assert is_open(0, 0, 0, 20)
    assert not is_open(0, 0, 15, 5)


def test_compare_of_a_program_with_itself_finds_no_difference() -> None:
    compared = compare("reach", "reach", seeds=range(2), backends=("kinematic", "kinematic"))
    # Two seeds cannot decide, so that the comparison ends with the first pair.
    assert len(compared.pairs) == 1
    assert compared.counts[0] == compared.counts[1]
    assert compared.difference == 0.0
    assert compared.first_differing is None


def test_compare_without_a_seed_is_refused() -> None:
    with pytest.raises(UsageError, match="at least one seed"):
        compare("reach", "reach", seeds=())


def test_p_value_is_that_of_the_exact_binomial_test() -> None:
    empty = ProgramComparison((), 0)
    assert empty.p_value == 1.0
