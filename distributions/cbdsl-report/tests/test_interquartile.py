"""Interquartile means, their intervals, and running means."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cbdsl_report.interquartile import band, interquartile_mean, mean, running_mean

TABLES = arrays(
    float,
    st.tuples(st.integers(1, 13), st.integers(1, 5)),
    elements=st.floats(-100, 100, width=16),
)


@given(TABLES)
def test_interquartile_mean_equals_the_mean_of_the_middle_half(values: np.ndarray) -> None:
    # Four copies of everything: a quarter of the rows is a whole number.
    rows = np.sort(np.repeat(values, 4, axis=0), axis=0)
    middle = rows[len(values) : 3 * len(values)].mean(axis=0)
    assert interquartile_mean(values) == pytest.approx(middle, abs=1e-9)


@given(TABLES, st.randoms())
def test_order_does_not_matter_and_a_shift_shifts(
    values: np.ndarray, random: np.random.Generator
) -> None:
    rows = list(values)
    random.shuffle(rows)
    found = interquartile_mean(values)
    assert interquartile_mean(np.array(rows)) == pytest.approx(found, abs=1e-9)
    assert interquartile_mean(values + 3) == pytest.approx(found + 3, abs=1e-9)


def test_interquartile_mean_of_four_ignores_one_outlier() -> None:
    values = np.array([[1.0], [2.0], [3.0], [1e9]])
    assert interquartile_mean(values) == pytest.approx([2.5])


@given(TABLES, st.sampled_from([interquartile_mean, mean]))
@settings(max_examples=20)
def test_bands_lie_between_the_extremes_and_are_repeatable(values: np.ndarray, center) -> None:
    found = band(values, center)
    for bound in found:
        assert (values.min(axis=0) - 1e-9 <= bound).all()
        assert (bound <= values.max(axis=0) + 1e-9).all()
    assert (found.lower <= found.upper + 1e-9).all()
    for one, other in zip(found, band(values, center), strict=True):
        assert (one == other).all()
    if len(values) == 1:
        assert (found.lower == found.upper).all() and (found.middle == values[0]).all()


def test_intervals_hold_the_true_mean_about_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    # 200 means of 20 trials each: bootstrap intervals are slightly too narrow with few trials.
    found = band(rng.normal(5, 1, (20, 200)), mean)
    held = ((found.lower < 5) & (found.upper > 5)).mean()
    assert 0.88 < held <= 0.99


@given(TABLES, st.integers(1, 7))
def test_running_mean_averages_the_last_values(values: np.ndarray, window: int) -> None:
    found = running_mean(values, window)
    for place in range(values.shape[1]):
        own = values[:, max(0, place + 1 - window) : place + 1].mean(axis=1)
        assert found[:, place] == pytest.approx(own, abs=1e-9)
