"""Percentages, their exact intervals, and how often chance passes their claims."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.reproduction.claim import Claim, above, at_least, below, between
from cbdsl.reproduction.percentage import chance_of_counts, percentage
from cbdsl.reproduction.quantity import Verdict


@pytest.mark.parametrize("trials", [2, 10, 30, 600])
@pytest.mark.parametrize(
    "claim", [above(50), at_least(95), below(15), between(60, 90)], ids=lambda claim: claim.text
)
def test_what_is_only_just_false_passes_in_one_of_forty(claim: Claim, trials: int) -> None:
    assert chance_of_counts(claim, trials) <= 0.025 + 1e-9


def test_the_chance_is_that_of_simulated_coins() -> None:
    trials, rng = 30, np.random.default_rng(0)
    hits = rng.binomial(trials, 0.5, size=20_000)
    passed = [
        percentage("", "", int(each), trials, above(50)).verdict is Verdict.REPRODUCED
        for each in np.unique(hits)
    ]
    share = sum(
        np.mean(hits == each) for each, ok in zip(np.unique(hits), passed, strict=True) if ok
    )
    assert share == pytest.approx(chance_of_counts(above(50), trials), abs=0.004)


def test_a_majority_of_few_is_undecided() -> None:
    assert percentage("", "", 6, 10, above(50)).verdict is Verdict.UNDECIDED
    assert percentage("", "", 27, 30, above(50)).verdict is Verdict.REPRODUCED


def test_a_single_trial_is_not_judged() -> None:
    assert percentage("", "", 1, 1, above(50)).verdict is Verdict.NOT_JUDGED


def test_none_of_no_trials_is_a_miss() -> None:
    assert percentage("", "", 0, 0, above(50)).verdict is Verdict.MISSED
