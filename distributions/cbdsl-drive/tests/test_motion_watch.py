"""Motion watch: motion without a command, and joints that do not follow."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.api.reading.robots import read_robot
from cbdsl_drive.motion_watch import MotionWatch
from tests.driven_robot import RATE, robot

TRACKING, LEAD = 0.1, 0.12
# Time in which the slowest controller of these tests reaches a reference, s.
DELAY = 0.06


class Law:
    """Control law that moves references by a speed, within the lead of measured positions."""

    def __init__(self, rate: float) -> None:
        self.period, self.references = 1.0 / rate, np.zeros(2)

    def step(self, positions: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        moved = self.references + self.period * speeds
        self.references = np.clip(moved, positions - LEAD, positions + LEAD)
        return self.references


def followed(rate: float, speeds: np.ndarray, seconds: float, delay: float) -> str:
    """Return the finding about joints that follow the law's references after a delay."""
    watch, law = MotionWatch(robot(), 1.0 / rate), Law(rate)
    sent = [np.zeros(2)]
    watch.begin(sent[0], np.zeros(2), 0.0)
    for tick in range(round(seconds * rate)):
        now = tick / rate
        positions = sent[max(0, len(sent) - 1 - round(delay * rate))]
        found = watch.strayed(positions, np.full(2, now), now)
        found = found or watch.stuck(sent[-1], positions, now)
        if found:
            return found
        sent.append(law.step(positions, speeds * math.sin(7.0 * now)).copy())
        watch.command(sent[-1], now)
    return ""


@given(st.floats(30.0, 250.0), st.floats(0.0, 2.0), st.floats(-2.0, 2.0), st.floats(0.0, DELAY))
def test_motion_watch_accepts_joints_that_follow(
    rate: float, first: float, second: float, delay: float
) -> None:
    assert followed(rate, np.array([first, second]), 3.0, delay) == ""


@given(st.floats(30.0, 250.0), st.floats(0.0, 0.09), st.floats(-2.0, 2.0))
def test_motion_watch_accepts_joints_with_a_lag(rate: float, lag: float, speed: float) -> None:
    watch, law, positions = MotionWatch(robot(), 1.0 / rate), Law(rate), np.zeros(2)
    watch.begin(positions, np.zeros(2), 0.0)
    share = 1.0 / (1.0 + lag * rate)
    for tick in range(round(2.0 * rate)):
        now = tick / rate
        assert watch.strayed(positions, np.full(2, now), now) == ""
        # The first joint runs and stops, and the second one swings.
        speeds = speed * np.array([0.4 * (now < 1.0), 0.4 * math.sin(4.0 * now)])
        references = law.step(positions, speeds)
        watch.command(references, now)
        positions = positions + share * (references - positions)


@given(st.floats(30.0, 250.0), st.floats(0.0, 0.3), st.floats(0.0, 1.5e-3))
def test_motion_watch_accepts_a_joint_that_an_obstacle_stops(
    rate: float, speed: float, quantum: float
) -> None:
    watch, law = MotionWatch(robot(), 1.0 / rate), Law(rate)
    rng, positions = np.random.default_rng(0), np.zeros(2)
    watch.begin(positions, np.zeros(2), 0.0)
    for tick in range(round(1.0 * rate)):
        now = tick / rate
        assert watch.strayed(positions, np.full(2, now), now) == ""
        references = law.step(positions, np.array([speed, 0.0]))
        watch.command(references, now)
        # An encoder's last digit flickers.
        positions = np.minimum(references, 0.1 * speed + quantum * rng.integers(0, 2, 2))


@given(
    st.floats(30.0, 250.0),
    st.floats(0.05, 2.0),
    st.sampled_from([-1.0, 1.0]),
    st.floats(-1.0, 1.0),
    st.floats(0.0, 2e-4),
)
def test_motion_watch_finds_a_joint_that_another_controller_carries(
    rate: float, speed: float, sign: float, asked: float, noise: float
) -> None:
    watch, law = MotionWatch(robot(), 1.0 / rate), Law(rate)
    rng, before = np.random.default_rng(0), np.zeros(2)
    watch.begin(before, np.full(2, -1.0 / rate), 0.0)
    # The program moves for a while before the other controller takes over.
    for tick in range(round(0.5 * rate)):
        before = law.step(before, np.array([asked, 0.0])).copy()
        watch.command(before, tick / rate)
        assert watch.strayed(before, np.full(2, tick / rate), tick / rate) == ""
    first = tick + 1
    taken, found, now = tick / rate, "", 0.0
    start = before.copy()
    # The law still asks for its own motion, and its references follow the carried joint.
    for tick in range(first, round(10.0 * rate)):
        now = tick / rate
        positions = start + np.array([sign * speed * (now - taken), 0.0])
        positions += noise * rng.standard_normal(2)
        if found := watch.strayed(positions, np.full(2, now), now):
            break
        watch.command(law.step(positions, np.array([asked, 0.0])), now)
    apart = abs(sign * speed - asked)
    # A joint that hardly moves where it is commanded is stopped, and another rule finds it.
    if apart > 0.4 and not -0.03 < sign * speed * np.sign(asked) < 0.25 * abs(asked):
        # Its own motion is not commanded, as far as it differs.
        assert found.startswith("joint 'first' moved by "), (now, positions, law.references)
        assert (now - taken) * (0.95 * apart - 0.05) < 0.031 + 3.0 * apart / rate + 4.0 * noise
    elif sign * asked < speed:
        assert found.startswith("joint 'first' moved by "), (now, positions, law.references)


def test_motion_watch_finds_exchanged_joints() -> None:
    watch, law = MotionWatch(robot(), 1.0 / RATE), Law(RATE)
    positions = np.zeros(2)
    watch.begin(positions, positions, 0.0)
    for tick in range(100):
        now = tick / RATE
        found = watch.strayed(positions, np.full(2, now), now)
        found = found or watch.stuck(law.references, positions, now)
        if found:
            break
        watch.command(law.step(positions, np.array([0.5, 0.0])), now)
        # The first reference moves the second joint.
        positions = law.references[::-1].copy()
    assert found.startswith("joint 'second' moved by 0.0"), found


@pytest.mark.parametrize(("distance", "found"), [(0.09, False), (0.11, True)])
def test_motion_watch_finds_a_joint_that_stands(distance: float, found: bool) -> None:
    watch, positions = MotionWatch(robot(), 1.0 / RATE), np.zeros(2)
    references = np.array([0.0, -distance])
    watch.begin(positions, positions, 0.0)
    assert watch.stuck(references, positions, 0.0) == ""
    assert watch.stuck(references, positions, 0.15) == "", "a joint has time to follow"
    assert bool(watch.stuck(references, positions, 0.25)) is found


def test_motion_watch_accepts_a_slow_joint_that_follows() -> None:
    watch = MotionWatch(robot(), 1.0 / RATE)
    for tick in range(100):
        positions = np.array([0.3 * tick / RATE, 0.0])
        assert watch.stuck(positions + np.array([LEAD, 0.0]), positions, tick / RATE) == ""


@pytest.mark.parametrize(
    ("joint", "found"),
    [("right_finger_1", False), ("right_spread", False), ("right_arm_1", True)],
)
def test_motion_watch_lets_objects_push_and_stop_fingers(joint: str, found: bool) -> None:
    document, _ = read_robot("dexter")
    watch = MotionWatch(document, 1.0 / RATE)
    names = [name for effector in document.effectors.values() for name in effector.joints]
    moved = np.array([0.08 * (name == joint) for name in names])
    watch.begin(0.0 * moved, 0.0 * moved, 0.0)
    watch.command(0.0 * moved, 0.0)
    assert bool(watch.strayed(moved, moved + 0.02, 0.02)) is found
    watch.stuck(2.0 * moved, 0.0 * moved, 0.0)
    assert bool(watch.stuck(2.0 * moved, 0.0 * moved, 0.3)) is found
