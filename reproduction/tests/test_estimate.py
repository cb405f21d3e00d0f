"""Statistics of samples, and the rate at which chance passes their claims."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.estimate import chance_of_samples, mean, mean_of, median
from cbdsl_reproduction.quantity import Verdict
from cbdsl_reproduction.region import ValueRegion, above, at_most, near


def claim(region: ValueRegion) -> Claim:
    return Claim("", "", region=region)


def test_many_even_samples_pass_by_chance_in_one_of_forty() -> None:
    samples = np.random.default_rng(0).normal(size=50)
    assert chance_of_samples(above(1), samples, mean) == pytest.approx(0.03, abs=0.025)


def test_few_skewed_samples_pass_by_chance_too_often() -> None:
    samples = np.random.default_rng(1).lognormal(sigma=2, size=12)
    assert chance_of_samples(at_most(3), samples, mean) > 0.05
    quantity = mean_of(claim(at_most(3)), (samples / 1000).tolist())
    assert quantity.chance > 0.05 and quantity.verdict is Verdict.UNDECIDED


def test_equal_samples_satisfy_only_claims_that_contain_their_value() -> None:
    samples = np.full(30, 5.0)
    assert chance_of_samples(at_most(25), samples, median) == 0.0
    assert mean_of(claim(at_most(25)), samples.tolist()).verdict is Verdict.REPRODUCED
    assert mean_of(claim(at_most(4)), samples.tolist()).verdict is Verdict.MISSED


def test_no_difference_has_to_be_shown() -> None:
    """Few samples with a wide interval around zero do not demonstrate a zero effect."""
    rng = np.random.default_rng(2)
    few, many = rng.normal(size=5), rng.normal(scale=0.1, size=100)
    assert mean_of(claim(near(0, 0.1)), few.tolist()).verdict is not Verdict.REPRODUCED
    assert mean_of(claim(near(0, 0.1)), many.tolist()).verdict is Verdict.REPRODUCED


def test_single_sample_is_not_judged_and_none_is_a_miss() -> None:
    assert mean_of(claim(above(0)), [1.0]).verdict is Verdict.NOT_JUDGED
    assert mean_of(claim(above(0)), []).verdict is Verdict.MISSED
