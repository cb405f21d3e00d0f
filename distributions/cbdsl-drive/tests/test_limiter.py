"""Limiter: no sequence of requests carries a reference over a limit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_drive.limiter import JointLimits, Limiter

PERIOD = 1.0 / 60.0
ROUNDING = 1e-9

LARGEST = float(np.finfo(np.float64).max)
requests = st.one_of(
    st.floats(-10.0, 10.0),
    st.floats(),
    st.sampled_from([math.nan, math.inf, -math.inf, LARGEST, -LARGEST]),
)


def limits(
    velocity: float, acceleration: float, lower: float = -1.0, upper: float = 1.0
) -> JointLimits:
    values = (lower, upper, velocity, acceleration, math.inf)
    return JointLimits(*(np.array([value]) for value in values))


@given(
    st.lists(st.tuples(requests, st.booleans()), min_size=1, max_size=80),
    st.floats(0.05, 20.0),
    st.floats(0.5, 500.0),
    st.floats(-1.0, 1.0),
)
def test_limiter_keeps_all_limits_for_any_request(
    asked: list[tuple[float, bool]], velocity: float, acceleration: float, start: float
) -> None:
    limiter = Limiter(limits(velocity, acceleration), PERIOD)
    limiter.reset(np.array([start]))
    position, speed = start, 0.0
    for request, brakes in asked:
        reference = limiter.brake() if brakes else limiter.approach(np.array([request]))
        moved = (float(reference[0]) - position) / PERIOD
        assert -1.0 <= reference[0] <= 1.0
        assert abs(moved) <= velocity + ROUNDING / PERIOD
        assert abs(moved - speed) <= acceleration * PERIOD + 2 * ROUNDING / PERIOD
        position, speed = float(reference[0]), moved


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.2, 5.0), st.floats(1.0, 100.0))
def test_limiter_reaches_a_steady_request_without_overshoot(
    start: float, goal: float, velocity: float, acceleration: float
) -> None:
    limiter = Limiter(limits(velocity, acceleration), PERIOD)
    limiter.reset(np.array([start]))
    way: list[float] = []
    # A reference that stands does not move again.
    while len(way) < 1500 and not (way and limiter.stands):
        way.append(float(limiter.approach(np.array([goal]))[0]))
    low, high = sorted((start, goal))
    assert all(low - ROUNDING <= position <= high + ROUNDING for position in way)
    assert abs(way[-1] - goal) < 1e-6
    assert limiter.brake()[0] == way[-1] or abs(limiter.positions[0] - way[-1]) < 1e-6


@pytest.mark.parametrize("bound", [1.0, math.inf])
@pytest.mark.parametrize("request_", [LARGEST, -LARGEST, 1e200])
def test_limiter_approaches_the_largest_numbers_without_overflow(
    request_: float, bound: float
) -> None:
    limiter = Limiter(limits(2.0, 40.0, -bound, bound), PERIOD)
    first = limiter.approach(np.array([request_]))
    assert first[0] == pytest.approx(math.copysign(40.0 * PERIOD**2, request_))
    for _ in range(20):
        limiter.approach(np.array([request_]))
    assert limiter.velocities[0] == math.copysign(2.0, request_)


def test_limiter_turns_endless_joints_without_position_limits() -> None:
    limiter = Limiter(limits(2.0, 40.0, -math.inf, math.inf), PERIOD)
    limiter.reset(np.array([50.0]))
    for _ in range(600):
        reference = limiter.approach(np.array([1e6]))
    assert reference[0] > 60.0
    assert limiter.velocities[0] == 2.0


def test_limiter_starts_at_rest_after_each_reset() -> None:
    limiter = Limiter(limits(2.0, 40.0), PERIOD)
    for _ in range(5):
        limiter.approach(np.array([1.0]))
    assert not limiter.stands
    limiter.reset(np.array([0.5]))
    assert limiter.stands
    assert limiter.brake()[0] == 0.5


def test_limiter_lets_a_joint_that_starts_outside_return() -> None:
    limiter = Limiter(limits(1.0, 20.0), PERIOD)
    limiter.reset(np.array([1.02]))
    assert limiter.approach(np.array([2.0]))[0] == 1.02
    for _ in range(100):
        reference = limiter.approach(np.array([0.5]))
    assert abs(reference[0] - 0.5) < 1e-6
