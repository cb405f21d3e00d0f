"""Motion of the trials' arm: no lag that depends on when commands come between two ticks."""

from __future__ import annotations

import pytest
from cell_motion import CellMotion
from hypothesis import given
from hypothesis import strategies as st

PERIOD, SPEED = 1.0 / 60.0, 0.6


# Share of a period from each tick to the next command; periods until a reference is reached.
@given(st.floats(0.01, 0.99), st.sampled_from([1, 3]))
def test_moving_arm_lags_by_the_time_of_a_reference_at_any_phase(
    share: float, horizon: int
) -> None:
    arm = CellMotion([0.0])
    for tick in range(60):
        arm.follow(tick * PERIOD)
        now = (tick + share) * PERIOD
        arm.command([SPEED * (now + PERIOD)], now, now, now + horizon * PERIOD)
    lag = SPEED * 60 * PERIOD - arm.positions[0]
    assert lag < SPEED * PERIOD * (horizon + 1)


def test_stopped_arm_stays_where_it_is() -> None:
    arm = CellMotion([0.0, 1.0])
    arm.command([1.0, 0.0], 5.0, 4.0, 6.0)
    arm.follow(5.5)
    arm.stop()
    arm.follow(9.0)
    assert arm.positions == pytest.approx([0.5, 0.5])
