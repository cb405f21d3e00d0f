"""Watchdog: repeats, holds, and stops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cbdsl_drive.limiter import JointLimits
from cbdsl_drive.watchdog import Watchdog, WatchdogPhase

PERIOD, DEADLINE = 0.02, 0.05
LIMITS = JointLimits(*(np.array([value]) for value in (-1.0, 1.0, 2.0, 40.0, math.inf)))


def guarding() -> Watchdog:
    dog = Watchdog(LIMITS, PERIOD, DEADLINE, start=0.05)
    dog.note_positions(np.zeros(1))
    dog.request(np.array([0.02]), 0.0)
    return dog


def test_watchdog_waits_for_measured_positions() -> None:
    dog = Watchdog(LIMITS, PERIOD, DEADLINE, start=0.05)
    dog.request(np.array([0.0]), 0.0)
    assert dog.tick(0.0) is None
    assert dog.phase is WatchdogPhase.WAITING


def test_watchdog_repeats_until_the_deadline_and_then_holds() -> None:
    dog = guarding()
    assert dog.tick(0.02) is not None
    assert dog.phase is WatchdogPhase.REPEATING
    first = dog.tick(0.06)
    assert dog.phase is WatchdogPhase.HOLDING
    assert dog.cause == "no reference for 60 ms"
    held = [dog.tick(0.06 + PERIOD * i) for i in range(1, 10)]
    assert first is not None
    assert all(each is not None for each in held)
    assert held[-1] == held[-2], "it stands"


def waiting() -> Watchdog:
    """Return a watchdog whose program ended at 0.02 rad, while the robot sags at 0."""
    dog = guarding()
    for now in np.arange(0.02, 0.2, PERIOD):
        dog.request(np.array([0.02]), float(now))
        dog.tick(float(now))
    dog.rest()
    assert [dog.tick(float(now)) for now in np.arange(0.2, 0.31, PERIOD)] == [None] * 6
    assert dog.phase is WatchdogPhase.WAITING
    return dog


def test_watchdog_that_waits_refuses_references_far_from_the_robot() -> None:
    dog = waiting()
    dog.request(np.array([0.5]), 0.4)
    assert dog.phase is WatchdogPhase.HOLDING, "the next program begins at the robot"


def test_watchdog_goes_on_from_references_that_the_controller_keeps() -> None:
    dog = waiting()
    dog.request(np.array([0.02]), 0.3)
    assert dog.tick(0.32) == 0.02, "the robot does not sag further"


def test_watchdog_begins_at_a_robot_that_was_moved_while_it_waited() -> None:
    dog = waiting()
    dog.note_positions(np.array([0.8]))
    dog.request(np.array([0.8]), 0.3)
    assert dog.tick(0.32) == 0.8


@pytest.mark.parametrize("first", [0.02, math.nan])
def test_watchdog_that_waited_sends_no_old_references_when_it_holds(first: float) -> None:
    dog = waiting()
    dog.note_positions(np.array([0.8]))
    dog.request(np.array([first]), 0.3)
    assert dog.phase is WatchdogPhase.HOLDING
    assert dog.tick(0.32) is None


def test_watchdog_waits_for_a_computing_program_and_stops_one_that_hangs_at_rest() -> None:
    dog = guarding()
    for now in np.arange(0.02, 0.2, PERIOD):
        dog.request(np.array([0.02]), float(now))
        dog.tick(float(now))
    for now in np.arange(0.2, 2.0, PERIOD):
        dog.tick(float(now))
        if now < 0.6:
            assert dog.phase is WatchdogPhase.REPEATING, "it plans a path"
    assert dog.phase is WatchdogPhase.STOPPED
    assert dog.cause == "no reference for 520 ms"


@pytest.mark.parametrize("speed", [0.05, 0.5, 1.9])
def test_watchdog_stops_a_program_that_is_killed_at_any_speed(speed: float) -> None:
    dog = guarding()
    for tick in range(10):
        dog.request(np.array([0.02 + speed * PERIOD * tick]), tick * PERIOD)
        dog.tick(tick * PERIOD)
    # Slow references are reached before the deadline, so that the robot stands already.
    for now in np.arange(10, 100) * PERIOD:
        dog.tick(float(now))
    assert dog.phase is WatchdogPhase.STOPPED
    assert dog.cause == "no reference for 60 ms"


def test_watchdog_holds_a_program_that_rests_far_from_its_references() -> None:
    dog = guarding()
    dog.tick(0.02)
    dog.request(np.array([0.9]), 0.04)
    dog.rest()
    for now in np.arange(0.04, 0.2, PERIOD):
        dog.tick(float(now))
    assert dog.phase is WatchdogPhase.HOLDING


def test_watchdog_stops_a_program_that_resumes_and_ends_in_motion() -> None:
    dog = waiting()
    for now in np.arange(0.32, 0.5, PERIOD):
        dog.request(np.array([0.04 if now < 0.33 else 0.9]), float(now))
        dog.tick(float(now))
    for now in np.arange(0.5, 2.0, PERIOD):
        dog.tick(float(now))
    assert dog.phase is WatchdogPhase.STOPPED
    assert dog.cause.startswith("no reference for ")


def test_watchdog_holds_after_its_own_suspension_at_rest() -> None:
    dog = guarding()
    for now in np.arange(0.02, 0.2, PERIOD):
        dog.request(np.array([0.02]), float(now))
        dog.tick(float(now))
    # References that queued come after the first tick.
    dog.tick(0.8)
    assert dog.cause == "the watchdog was suspended for 620 ms"


def test_watchdog_stops_and_ignores_a_program_that_returns() -> None:
    dog = guarding()
    times = np.arange(0.02, 2.0, PERIOD)
    sent = [dog.tick(float(now)) for now in times]
    assert dog.phase is WatchdogPhase.STOPPED
    assert sent[-1] is None
    dog.request(np.array([0.5]), 2.0)
    assert dog.tick(2.0) is None


def test_watchdog_refuses_a_first_reference_far_from_the_robot() -> None:
    dog = Watchdog(LIMITS, PERIOD, DEADLINE, start=0.05)
    dog.note_positions(np.zeros(1))
    dog.request(np.array([0.5]), 0.0)
    assert dog.phase is WatchdogPhase.HOLDING
    assert dog.tick(0.0) is None


def test_watchdog_ignores_measured_positions_that_are_not_finite() -> None:
    dog = Watchdog(LIMITS, PERIOD, DEADLINE, start=0.05)
    dog.note_positions(np.array([math.nan]))
    dog.request(np.zeros(1), 0.0)
    assert dog.phase is WatchdogPhase.WAITING
    dog.note_positions(np.zeros(1))
    dog.request(np.zeros(1), 0.0)
    dog.note_positions(np.array([math.nan]))
    assert dog.tick(0.0) == 0.0


def test_watchdog_holds_after_its_own_suspension() -> None:
    dog = guarding()
    sent = dog.tick(0.02)
    # The reference queued while the watchdog was suspended, and its program may have ended.
    dog.request(np.array([0.5]), 0.62)
    first = dog.tick(0.62)
    assert dog.phase is WatchdogPhase.HOLDING
    assert dog.cause == "the watchdog was suspended for 600 ms"
    assert first is not None
    rest = [dog.tick(0.62 + PERIOD * i) for i in range(1, 10)]
    assert rest[-1] == rest[-2], "it stands"
    assert first == rest[-1] == sent, "the controller stood there already"


def test_watchdog_stops_only_once_the_robot_stands() -> None:
    slow = JointLimits(*(np.array([v]) for v in (-100.0, 100.0, 2.0, 0.5, math.inf)))
    dog, now, sent = Watchdog(slow, PERIOD, DEADLINE, start=0.05), 0.0, [0.0]
    dog.note_positions(np.zeros(1))
    dog.request(np.zeros(1), now)
    for tick in range(800):
        now = tick * PERIOD
        # The program ends while the robot moves at 2 rad/s, and braking takes 4 s.
        if tick < 250:
            dog.request(np.array([90.0]), now)
        if (references := dog.tick(now)) is not None:
            sent.append(float(references[0]))
    assert dog.phase is WatchdogPhase.STOPPED
    assert sent[-1] == sent[-2], "the last reference stands"
    assert np.abs(np.diff(sent, 2)).max() <= 0.5 * PERIOD**2 + 1e-9


@pytest.mark.parametrize("phase", [WatchdogPhase.HOLDING, WatchdogPhase.STOPPED])
def test_watchdog_never_leaves_a_hold(phase: WatchdogPhase) -> None:
    dog = guarding()
    end = 0.5 if phase is WatchdogPhase.HOLDING else 2.0
    for now in np.arange(0.02, end, PERIOD):
        dog.tick(float(now))
    assert dog.phase is phase
    cause, at = dog.cause, dog.tick(end)
    for request in (0.02, 0.5, math.nan):
        dog.note_positions(np.array([0.02]))
        dog.request(np.array([request]), end)
        assert dog.tick(end) == at
        assert dog.phase is phase
    assert dog.cause == cause


# Requests near the robot also resume after a pause.
near = st.sampled_from([-0.04, 0.0, 0.04, "rest"])
requests = st.one_of(st.floats(-3.0, 3.0), near, st.floats(), st.none())


@given(st.lists(requests, max_size=60))
@example([0.04] * 5 + ["rest", None, None, -0.04])
def test_watchdog_keeps_limits_and_waits_at_a_word_only(asked: list[float | str | None]) -> None:
    dog, before, speed, is_resting = guarding(), 0.0, 0.0, False
    for tick, request in enumerate(asked, 1):
        if request == "rest":
            dog.rest()
        elif request is not None:
            dog.request(np.array([request]), tick * PERIOD)
        is_resting = request == "rest" or (request is None and is_resting)
        repeated = dog.phase is WatchdogPhase.REPEATING
        sent = dog.tick(tick * PERIOD)
        assert not repeated or is_resting or dog.phase is not WatchdogPhase.WAITING
        if sent is None:
            continue
        moved = (float(sent[0]) - before) / PERIOD
        assert -1.0 <= sent[0] <= 1.0
        assert abs(moved) <= 2.0 + 1e-6
        assert abs(moved - speed) <= 40.0 * PERIOD + 1e-6
        before, speed = float(sent[0]), moved
