"""One-sided potentials: free beside their bound, a spring beyond it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.potentials.bound import bound

numbers = st.floats(-10.0, 10.0)


@given(numbers, numbers)
def test_bound_of_a_number_is_free_on_one_side_and_a_spring_on_the_other(
    value: float, reference: float
) -> None:
    upper, lower = bound((0,), 1.0), bound((0,), -1.0)
    results = [
        each.evaluate(np.array([value]), np.array([reference]), 1) for each in (upper, lower)
    ]
    (over, over_error, over_slope), (under, under_error, under_slope) = results
    excess, shortfall = max(value - reference, 0.0), max(reference - value, 0.0)
    assert over == pytest.approx(excess**2 / 2) and under == pytest.approx(shortfall**2 / 2)
    assert over_error[0] == pytest.approx(-excess) and under_error[0] == pytest.approx(shortfall)
    assert over_slope[0, 0] == (value > reference) and under_slope[0, 0] == (value < reference)


def test_bound_of_one_axis_leaves_the_others_free() -> None:
    value, reference = np.array([5.0, 5.0, 1.0]), np.array([0.0, 0.0, 3.0])
    phi, residual, slope = bound((2,), -1.0).evaluate(value, reference, 3)
    assert phi == pytest.approx(2.0) and residual == pytest.approx([2.0])
    assert slope.tolist() == [[0.0, 0.0, 1.0]]
