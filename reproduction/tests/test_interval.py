"""Bootstrapped intervals of means and medians."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_reproduction.interval import (
    bootstrap_interval,
    interquartile_interval,
    interquartile_mean,
    interval_of,
    median_interval,
    resampled_interval,
)


def test_bootstrapped_intervals_of_normal_samples_are_about_two_standard_errors() -> None:
    samples = np.random.default_rng(0).normal(3.0, 2.0, 400)
    low, high = bootstrap_interval(samples.tolist())
    error = samples.std() / 20
    assert low == pytest.approx(samples.mean() - 1.96 * error, abs=0.2 * error)
    assert high == pytest.approx(samples.mean() + 1.96 * error, abs=0.2 * error)


def test_bootstrapping_is_repeatable_and_needs_samples() -> None:
    assert bootstrap_interval([1.0, 2.0, 4.0]) == bootstrap_interval([1.0, 2.0, 4.0])
    assert bootstrap_interval([5.0]) == (5.0, 5.0)
    with pytest.raises(ValueError, match="no samples"):
        bootstrap_interval([])


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=40))
def test_interquartile_mean_ignores_the_outer_quarters(
    values: list[float],
) -> None:
    mean = float(interquartile_mean(np.array(values)))
    ordered, out = sorted(values), len(values) // 4
    assert ordered[out] - 1e-9 <= mean <= ordered[len(values) - out - 1] + 1e-9
    if out:
        ordered[-1] = 1e9
        assert float(interquartile_mean(np.array(ordered))) == pytest.approx(mean)


def test_interquartile_means_go_along_the_first_axis() -> None:
    values = np.random.default_rng(0).normal(size=(30, 4)) + np.arange(4)
    low, high = interquartile_interval(values, seed=1)
    middle = interquartile_mean(values)
    assert low.shape == high.shape == middle.shape == (4,)
    assert (low < middle).all() and (middle < high).all()
    one_low, one_high = interquartile_interval(values[:, 0], seed=1)
    assert (one_low, one_high) == pytest.approx((low[0], high[0]))


def test_interval_of_a_statistic_is_that_of_its_bootstrap() -> None:
    values = np.random.default_rng(0).normal(size=40)
    low, high = interquartile_interval(values)
    assert interval_of(interquartile_mean)(values) == (float(low), float(high))


def test_resampled_intervals_of_a_mean_are_bootstrapped() -> None:
    samples = np.random.default_rng(0).normal(size=50).tolist()
    low, high = resampled_interval(samples, lambda each: float(np.mean(each)))
    assert (low, high) == pytest.approx(bootstrap_interval(samples), abs=0.05)


def test_interquartile_interval_of_no_samples_is_refused() -> None:
    with pytest.raises(ValueError, match="no samples"):
        interquartile_interval(np.empty((0, 3)))


@given(st.lists(st.sampled_from([5.0, 10.0, 20.0, math.inf]), min_size=1, max_size=30))
def test_interval_of_a_median_contains_it_with_infinite_samples(
    values: list[float],
) -> None:
    low, high = median_interval(np.array(values))
    assert low <= np.median(values) <= high
