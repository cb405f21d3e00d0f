"""Supervisor: limits for any references, and holds that only a person ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cbdsl.extend.driver import (
    DescriptionSample,
    FaultSample,
    JointSample,
    Sample,
    StopSample,
)
from cbdsl.robot.urdf_reader import parse_urdf
from cbdsl_drive.joint_limits import joint_limits
from cbdsl_drive.limiter import JointLimits
from cbdsl_drive.safety_supervisor import SafetySupervisor, State
from cbdsl_drive.watchdog import Watchdog, WatchdogPhase
from tests.driven_robot import NAMES, URDF, robot

EPOCH = 1.7e9
# Relative error of a velocity that is a difference of two rounded positions.
ROUNDING = 1e-9


class Rig:
    """Supervisor of an ideal robot that reaches each reference within a period.

    Args:
        speed: Velocity limit of the first joint, rad/s.
        acceleration: Acceleration limit of both joints, rad/s^2.
        rate: Control rate, Hz.
    """

    def __init__(
        self, speed: float = 2.0, acceleration: float = 40.0, rate: float = 50.0, **driver: object
    ) -> None:
        document = robot(acceleration=acceleration, **driver)
        text = URDF.replace('velocity="2"', f'velocity="{speed}"')
        model = parse_urdf(text, Path("rail.urdf"))
        self.period, self.limits = 1.0 / rate, joint_limits(document, model)
        self.supervisor = SafetySupervisor(document, model, self.period)
        self.now, self.measured = 0.0, np.zeros(2)
        self.sent: list[np.ndarray] = []
        self.begin()

    def begin(self) -> None:
        """Begin an episode of a robot that is off."""
        self.tell()
        self.supervisor.make_ready(self.now)
        self.sent = [self.measured.copy()]

    def run(self) -> None:
        """Send the first reference."""
        self.keep(self.supervisor.admit(self.measured, self.now))

    def pass_time(self, seconds: float) -> None:
        self.now += seconds

    def tell(self, **changes: object) -> None:
        """Report joint states, with changes."""
        sample = JointSample("arm", EPOCH + self.now, NAMES, tuple(self.measured), (0.0, 0.0))
        self.hear(sample._replace(**changes))

    def hear(self, sample: Sample) -> None:
        self.supervisor.note(sample, self.now, EPOCH + self.now)

    def keep(self, references: np.ndarray | None) -> None:
        if references is not None:
            self.sent.append(references)
            self.measured = references.copy()

    def ask(self, references: np.ndarray) -> None:
        """Run a tick of a program."""
        self.pass_time(self.period)
        self.tell()
        self.supervisor.check(self.now)
        self.keep(self.supervisor.admit(references, self.now))


def within(limits: JointLimits, sent: list[np.ndarray], period: float) -> bool:
    """Return whether references from rest on are finite and within all limits."""
    positions = np.array(sent)
    velocities = np.diff(positions, axis=0, prepend=positions[:1]) / period
    changes = np.diff(velocities, axis=0)
    error = ROUNDING / period
    return bool(
        np.isfinite(positions).all()
        and (positions >= limits.lower).all()
        and (positions <= limits.upper).all()
        and (np.abs(velocities) <= limits.velocity + error).all()
        and (np.abs(changes) <= limits.acceleration * period + 2.0 * error).all()
    )


FAULTS: dict[str, Callable[[Rig], None]] = {
    "hold": lambda rig: rig.supervisor.hold("a person halted it"),
    "blind hold": lambda rig: rig.supervisor.hold("it is blind", blind=True),
    "nan state": lambda rig: rig.tell(positions=(math.nan, 0.0)),
    "clock": lambda rig: rig.tell(stamp=EPOCH + rig.now + 10.0),
    "commander": lambda rig: rig.hear(FaultSample("arm", "another commander writes")),
    "stop": lambda rig: rig.hear(StopSample("arm", True)),
    "other robot": lambda rig: rig.hear(DescriptionSample("arm", "<robot/>")),
    "nan reference": lambda rig: rig.ask(np.array([math.nan, 0.0])),
    "silence": lambda rig: (rig.pass_time(0.06), rig.supervisor.check(rig.now)),
    "suspension": lambda rig: (rig.pass_time(1.0), rig.tell(), rig.supervisor.check(rig.now)),
}
HARMLESS: dict[str, Callable[[Rig], None]] = {
    "states": lambda rig: rig.tell(),
    "no stop": lambda rig: rig.hear(StopSample("arm", False)),
    "own description": lambda rig: rig.hear(DescriptionSample("arm", URDF)),
    "check": lambda rig: rig.supervisor.check(rig.now),
    "resume": lambda rig: rig.supervisor.resume(rig.now),
    "settle": lambda rig: rig.keep(rig.supervisor.settle(rig.now)),
    "forget": lambda rig: rig.supervisor.forget_mismatches(),
    "obstacles": lambda rig: rig.supervisor.obstacles(),
    "ask": lambda rig: rig.ask(rig.measured + 0.01),
    "ask far": lambda rig: rig.ask(np.array([1e308, -1e308])),
}
EVENTS = FAULTS | HARMLESS


@pytest.mark.parametrize("running", [False, True])
@pytest.mark.parametrize("name", FAULTS)
def test_supervisor_after_a_fault_is_held_until_its_release(name: str, running: bool) -> None:
    rig = Rig()
    if running:
        rig.run()
        for _ in range(3):
            rig.ask(rig.measured + 0.03)
    # A robot that stands in ``ready`` has no late program.
    if name == "suspension" and not running:
        return
    FAULTS[name](rig)
    assert rig.supervisor.state is State.HELD
    cause = rig.supervisor.cause
    assert cause
    for event in EVENTS.values():
        event(rig)
        assert rig.supervisor.state is State.HELD
        assert rig.supervisor.cause == cause, "the first cause is kept"
    assert rig.supervisor.obstacles()[0] == f"the robot is held: {cause}"
    for change in (rig.supervisor.rest, lambda: rig.supervisor.make_ready(rig.now)):
        with pytest.raises(AssertionError):
            change()
    rig.supervisor.release()
    assert rig.supervisor.state is State.OFF


@pytest.mark.parametrize("state", [State.OFF, State.READY, State.RUNNING])
def test_release_of_a_robot_that_is_not_held_changes_nothing(state: State) -> None:
    rig = Rig()
    if state is State.OFF:
        rig.supervisor.rest()
    elif state is State.RUNNING:
        rig.run()
    rig.supervisor.release()
    assert rig.supervisor.state is state


@pytest.mark.parametrize("name", FAULTS)
def test_supervisor_that_is_off_neither_holds_nor_sends(name: str) -> None:
    rig = Rig()
    rig.supervisor.rest()
    if "hold" not in name:
        FAULTS[name](rig)
        assert rig.supervisor.state is State.OFF
    assert rig.supervisor.admit(np.zeros(2), rig.now) is None
    assert rig.supervisor.settle(rig.now) is None


def test_supervisor_rests_from_running_by_a_hold_only() -> None:
    rig = Rig()
    rig.run()
    with pytest.raises(AssertionError):
        rig.supervisor.rest()


def test_supervisor_starts_references_from_the_newest_positions() -> None:
    rig = Rig()
    # The robot was moved after it was ready.
    rig.measured = np.array([0.3, -0.3])
    rig.pass_time(rig.period)
    rig.tell()
    assert rig.supervisor.admit(np.array([0.3, -0.3]), rig.now) == pytest.approx([0.3, -0.3])
    assert rig.supervisor.state is State.RUNNING


def test_held_joint_that_lags_brakes_and_does_not_return() -> None:
    rig = Rig(tracking=0.1)
    rig.run()
    for tick in range(1, 20):
        rig.ask(tick * np.array([0.03, 0.01]))
        # The first joint is stuck.
        rig.measured[0] = 0.0
        if rig.supervisor.state is State.HELD:
            break
    assert "joint 'first' is 0.3" in rig.supervisor.cause
    assert "from its reference and does not follow it" in rig.supervisor.cause
    reached, measured = rig.sent[-1], rig.supervisor.joints.positions.copy()
    for _ in range(40):
        rig.keep(rig.supervisor.settle(rig.now))
        rig.pass_time(rig.period)
    assert rig.sent[-1][0] >= reached[0], "a return would release the joint with a jerk"
    assert rig.sent[-1][1] == pytest.approx(measured[1], abs=1e-4)
    assert within(rig.limits, rig.sent, rig.period)


def test_held_robot_stops_on_a_long_way_back() -> None:
    rig = Rig(speed=0.05, tracking=0.3)
    rig.run()
    rig.measured = np.array([0.25, 0.0])
    rig.pass_time(rig.period)
    rig.tell()
    rig.supervisor.hold("a person halted it")
    steps = 0
    while rig.supervisor.settle(rig.now) is not None and steps < 100:
        rig.pass_time(rig.period)
        steps += 1
    assert 20 <= steps <= 25


@pytest.mark.parametrize(("pause", "sends"), [(0.02, True), (0.3, False)])
def test_held_robot_whose_controllers_stand_gets_no_reference(pause: float, sends: bool) -> None:
    rig = Rig(horizon=0.1)
    rig.run()
    for _ in range(5):
        rig.ask(rig.measured + 0.03)
    rig.supervisor.hold("a person halted it")
    rig.pass_time(pause)
    assert (rig.supervisor.settle(rig.now) is not None) is sends


def test_emergency_stop_of_one_driver_does_not_release_that_of_another() -> None:
    document = robot()
    section = document.drivers["arm"].model_copy(update={"stop": "/stop"})
    sensors = section.model_copy(update={"moves": (), "commands": None})
    document = document.model_copy(update={"drivers": {"arm": section, "cell": sensors}})
    model = parse_urdf(URDF, Path("rail.urdf"))
    supervisor = SafetySupervisor(document, model, 0.02)
    for driver, pressed in (("cell", True), ("arm", False)):
        supervisor.note(StopSample(driver, pressed), 0.0, EPOCH)
    assert "the emergency stop of driver 'cell' is pressed" in supervisor.obstacles()
    supervisor.note(StopSample("cell", False), 0.0, EPOCH)
    assert not any("emergency" in obstacle for obstacle in supervisor.obstacles())


def test_emergency_stop_of_two_publishers_is_released_by_both() -> None:
    rig = Rig(stop="/stop")
    rig.supervisor.rest()
    for source, pressed in ((1, True), (2, False), (2, True), (1, False)):
        rig.hear(StopSample("arm", pressed, source))
        assert "the emergency stop of driver 'arm' is pressed" in rig.supervisor.obstacles()
    rig.hear(StopSample("arm", False, 2))
    assert not any("emergency" in obstacle for obstacle in rig.supervisor.obstacles())


@pytest.mark.parametrize(("speed", "patience"), [(0.01, 0.5), (0.05, 0.05)])
def test_patience_is_longer_while_references_stand_only(speed: float, patience: float) -> None:
    rig = Rig()
    rig.run()
    for tick in range(1, 30):
        rig.ask(np.array([speed * rig.period * tick, 0.0]))
    assert rig.supervisor.patience == patience


wild = st.one_of(st.floats(-3.0, 3.0), st.floats())
asked = st.tuples(wild, wild)
actions = st.one_of(asked, st.integers(1, 30), st.sampled_from(sorted(EVENTS)), st.just("release"))


@settings(max_examples=150, deadline=None)
@given(
    st.lists(actions, max_size=40),
    st.floats(0.05, 10.0),
    st.floats(0.5, 500.0),
    st.floats(30.0, 500.0),
)
@example([(1.0, 0.0)] * 25, 1.0, 1.0, 30.0)
def test_supervisor_and_watchdog_keep_all_limits_for_any_program(
    sequence: list[tuple[float, float] | int | str], speed: float, acceleration: float, rate: float
) -> None:
    rig = Rig(speed, acceleration, rate, tracking=10.0)
    guard, guarded = _guard(rig)
    rig.run()
    for action in sequence:
        held, before, began = rig.supervisor.state is State.HELD, len(rig.sent), rig.now
        _act(rig, action)
        if held and action == "release":
            assert rig.supervisor.state is State.RUNNING
            guard, guarded = _guard(rig)
            began = rig.now
        elif held:
            assert rig.supervisor.state is State.HELD
        _forward(rig, guard, guarded, before, began)
    _end(rig, guard, guarded)


def _guard(rig: Rig) -> tuple[Watchdog, list[np.ndarray]]:
    """Return a watchdog behind the supervisor, and the list of its references."""
    guard = Watchdog(rig.limits, rig.period, deadline=0.05, start=0.05)
    guard.note_positions(rig.sent[0])
    return guard, [rig.sent[0]]


def _forward(
    rig: Rig, guard: Watchdog, guarded: list[np.ndarray], before: int, began: float
) -> None:
    """Let the watchdog tick since a time, and forward the references sent since then."""
    new: list[np.ndarray | None] = [*rig.sent[before:]]
    times = [*np.arange(began + rig.period, rig.now - 0.5 * rig.period, rig.period), rig.now]
    references_of_ticks = [None] * (len(times) - len(new)) + new
    times += [rig.now] * (len(new) - len(times))
    for now, references in zip(map(float, times), references_of_ticks, strict=True):
        if references is not None:
            guard.request(references, now)
        if (sent := guard.tick(now)) is not None:
            guarded.append(sent)


def _act(rig: Rig, action: tuple[float, float] | int | str) -> None:
    if isinstance(action, int):  # a program that repeats its last reference, or settles
        for _ in range(action):
            rig.ask(rig.measured)
            rig.keep(rig.supervisor.settle(rig.now))
    elif isinstance(action, tuple):
        rig.ask(np.array(action))
    elif action != "release":
        EVENTS[action](rig)
    elif rig.supervisor.state is State.HELD:
        assert within(rig.limits, rig.sent, rig.period)
        rig.supervisor.release()
        rig.supervisor.rest()
        rig.pass_time(1.0)
        rig.begin()
        rig.run()


def _end(rig: Rig, guard: Watchdog, guarded: list[np.ndarray]) -> None:
    """Hold the robot, and require that it comes to rest."""
    rig.supervisor.hold("the test ends")
    longest = float((rig.limits.velocity / rig.limits.acceleration).max())
    for _ in range(40 + math.ceil(longest * 2 / rig.period)):
        began = rig.now
        rig.pass_time(rig.period)
        rig.keep(rig.supervisor.settle(rig.now))
        # The program's last references are lost, so that the watchdog brakes by itself.
        _forward(rig, guard, guarded, len(rig.sent), began)
    assert rig.supervisor.settle(rig.now) is None
    assert within(rig.limits, rig.sent, rig.period)
    for _ in range(2 + math.ceil((1.5 + longest) / rig.period)):
        rig.pass_time(rig.period)
        if (sent := guard.tick(rig.now)) is not None:
            guarded.append(sent)
    assert within(rig.limits, guarded, rig.period)
    assert guard.phase in (WatchdogPhase.WAITING, WatchdogPhase.STOPPED)
