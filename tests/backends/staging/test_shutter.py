"""Images come at the rate of their cameras, at every control rate."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.backends.simulated_backend import Shutter


@given(st.integers(1, 120), st.integers(10, 500))
def test_shutter_opens_at_its_rate_in_a_second(rate: int, control: int) -> None:
    shutter = Shutter(float(rate), 1 / control)
    opened = [tick for tick in range(5 * control) if shutter.opens(tick)]
    assert opened[0] == 0
    assert len(opened) == 5 * min(rate, control)
    gaps = {later - former for former, later in pairwise(opened)}
    assert max(gaps) - min(gaps) <= 1
    assert min(gaps) == pytest.approx(control / min(rate, control), abs=1)
