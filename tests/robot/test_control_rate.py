"""Control rates of one run: bounds, a physics rate that fits, and reasons of a refusal."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.api.reading.robots import read_robot
from cbdsl.diagnostics.errors import UsageError
from cbdsl.robot.control_rate import with_control_rate


@given(rate=st.floats(30.0, 1000.0))
def test_control_rate_within_bounds_keeps_whole_physics_steps(rate: float) -> None:
    robot = with_control_rate(read_robot("dexter")[0], rate)
    ratio = robot.simulation.physics_rate / rate
    assert robot.control.rate == rate
    assert ratio == pytest.approx(round(ratio), abs=1e-9)
    assert robot.simulation.physics_rate >= 240.0 - 1e-6


def test_no_control_rate_keeps_the_document() -> None:
    robot, _ = read_robot("dexter")
    assert with_control_rate(robot, None) is robot


@pytest.mark.parametrize("rate", [0.0, -60.0, 1e4, float("nan"), float("inf")])
def test_control_rate_out_of_range_is_refused_with_its_bounds(rate: float) -> None:
    with pytest.raises(UsageError, match="from 1 to 1000 Hz"):
        with_control_rate(read_robot("dexter")[0], rate)


def test_control_rate_that_does_not_fit_names_each_reason() -> None:
    robot, _ = read_robot("dexter")
    with pytest.raises(UsageError) as caught:
        with_control_rate(robot, 10.0)
    text = str(caught.value)
    assert f"{robot.vision.rate:g} images per second" in text
    assert "the deadline of driver 'body', 50 ms, needs 30 Hz" in text
