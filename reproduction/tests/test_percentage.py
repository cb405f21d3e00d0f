"""Percentages, their exact intervals, and the rate at which chance passes their claims."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.percentage import (
    chance_of_counts,
    clustered_percentage,
    effective_number,
    percentage,
)
from cbdsl_reproduction.quantity import Verdict
from cbdsl_reproduction.region import ValueRegion, above, at_least, below, between


def claim(region: ValueRegion | None) -> Claim:
    return Claim("", "", "%", region=region)


@pytest.mark.parametrize("trials", [2, 10, 30, 600])
@pytest.mark.parametrize(
    "region", [above(50), at_least(95), below(15), between(60, 90)], ids=lambda region: region.text
)
def test_chance_of_a_barely_false_claim_is_at_most_one_in_forty(
    region: ValueRegion, trials: int
) -> None:
    assert chance_of_counts(region, trials) <= 0.025 + 1e-9


def test_chance_is_that_of_simulated_coins() -> None:
    trials, rng = 30, np.random.default_rng(0)
    hits = rng.binomial(trials, 0.5, size=20_000)
    passed = [
        percentage(claim(above(50)), int(each), trials).verdict is Verdict.REPRODUCED
        for each in np.unique(hits)
    ]
    share = sum(
        np.mean(hits == each) for each, ok in zip(np.unique(hits), passed, strict=True) if ok
    )
    assert share == pytest.approx(chance_of_counts(above(50), trials), abs=0.004)


def test_majority_of_few_trials_is_undecided() -> None:
    assert percentage(claim(above(50)), 6, 10).verdict is Verdict.UNDECIDED
    assert percentage(claim(above(50)), 27, 30).verdict is Verdict.REPRODUCED


def test_single_trial_is_not_judged() -> None:
    assert percentage(claim(above(50)), 1, 1).verdict is Verdict.NOT_JUDGED


def test_percentage_of_no_trials_is_missed() -> None:
    assert percentage(claim(above(50)), 0, 0).verdict is Verdict.MISSED


def test_independent_outcomes_of_a_trial_count_separately() -> None:
    rng = np.random.default_rng(1)
    hits, sizes = rng.binomial(20, 0.9, size=2000).tolist(), [20] * 2000
    assert effective_number(hits, sizes) == pytest.approx(40_000, rel=0.07)


def test_fully_correlated_outcomes_count_once_per_trial() -> None:
    hits, sizes = [20] * 60 + [0] * 40, [20] * 100
    assert effective_number(hits, sizes) == pytest.approx(99, rel=0.05)
    whole = clustered_percentage(claim(at_least(45)), hits, sizes, of="actions")
    assert whole.ours == 60
    assert whole.verdict is Verdict.REPRODUCED
    assert whole.note == "1200 of 2000 actions in 100 trials"
    # As many independent outcomes leave no doubt.
    assert percentage(claim(at_least(55)), 1200, 2000).verdict is Verdict.REPRODUCED
    surer = clustered_percentage(claim(at_least(55)), hits, sizes)
    assert surer.verdict is Verdict.UNDECIDED


def test_interval_of_few_certain_trials_is_wider_than_of_many() -> None:
    few, many = ([[40] * trials] * 2 for trials in (2, 25))
    most = claim(at_least(95))
    assert clustered_percentage(most, few[0], few[1]).verdict is Verdict.UNDECIDED
    assert clustered_percentage(most, many[0], many[1]).verdict is Verdict.REPRODUCED


def test_outcomes_of_a_single_trial_are_not_judged() -> None:
    for hits, sizes in (([40], [40]), ([40, 0], [40, 0])):
        single = clustered_percentage(claim(at_least(50)), hits, sizes)
        assert (single.ours, single.verdict) == (100, Verdict.NOT_JUDGED)
    assert clustered_percentage(claim(at_least(50)), [], []).verdict is Verdict.MISSED


def test_intervals_of_dependent_outcomes_have_their_nominal_coverage() -> None:
    rng, share, trials = np.random.default_rng(2), 0.45, 25
    covered = exact = 0
    for _ in range(400):
        own = rng.beta(4 * share, 4 * (1 - share), size=trials)
        sizes = rng.integers(20, 50, size=trials)
        hits = rng.binomial(sizes, own)
        intervals = (
            clustered_percentage(claim(None), hits.tolist(), sizes.tolist()).interval,
            percentage(claim(None), int(hits.sum()), int(sizes.sum())).interval,
        )
        inside = [each is not None and each[0] <= 100 * share <= each[1] for each in intervals]
        covered, exact = covered + inside[0], exact + inside[1]
    assert covered / 400 > 0.93
    assert exact / 400 < 0.7
