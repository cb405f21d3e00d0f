"""Follower: a controller that holds still where its trajectory ends."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("cyclonedds")

from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.follower import Follower

NOW = 1.7e9


def trajectory(
    *positions: float, stamp: float = NOW, horizon: float = 0.05, names: str = "ab"
) -> msg.JointTrajectory:
    point = msg.JointTrajectoryPoint(
        positions=list(positions), time_from_start=msg.Duration.of(horizon)
    )
    return msg.JointTrajectory(msg.Header(msg.Time.of(stamp)), list(names), [point])


def follower() -> Follower:
    arm = Follower(("a", "b"), np.zeros(2))
    arm.at(NOW)
    return arm


def test_follower_interpolates_and_holds_at_the_end() -> None:
    arm = follower()
    assert not arm.accept(trajectory(1.0, -1.0), 1, NOW)
    assert arm.at(NOW + 0.025) == pytest.approx([0.5, -0.5], abs=1e-3)
    assert arm.at(NOW + 0.06) == pytest.approx([1.0, -1.0])
    assert arm.at(NOW + 0.09) == pytest.approx([1.0, -1.0])


def test_follower_orders_joints_by_name() -> None:
    arm = follower()
    assert not arm.accept(trajectory(-1.0, 1.0, names="ba"), 1, NOW)
    assert arm.at(NOW + 0.06) == pytest.approx([1.0, -1.0])


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (trajectory(1.0, 1.0, stamp=NOW - 1.0), "is over already"),
        (trajectory(1.0, 1.0, names="ac"), "is for joints a, c"),
        (trajectory(float("nan"), 1.0), "not finite"),
        (trajectory(1.0), "lacks positions"),
        (msg.JointTrajectory(joint_names=["a", "b"]), "is over already"),
        (msg.Float64MultiArray(data=[1.0]), "1 positions"),
    ],
)
def test_follower_refuses_an_unsuitable_trajectory(message: object, problem: str) -> None:
    arm = follower()
    assert problem in arm.accept(message, 1, NOW)
    assert not arm.at(NOW + 0.05).any()


def test_follower_refuses_a_second_writer() -> None:
    arm = follower()
    assert not arm.accept(trajectory(0.1, 0.1), 1, NOW)
    assert "another writer" in arm.accept(trajectory(1.0, 1.0), 2, NOW + 0.01)
    assert not arm.accept(trajectory(1.0, 1.0, stamp=NOW + 2.0), 2, NOW + 2.0)


@given(st.floats(0.11, 5.0))
def test_stalled_follower_holds_its_position(stalled: float) -> None:
    arm = follower()
    assert not arm.accept(trajectory(1.0, 1.0, horizon=1.0), 1, NOW)
    before = arm.at(NOW + 0.05)
    assert arm.at(NOW + 0.05 + stalled) == pytest.approx(before)
