"""Robots with LeRobot's interface: limits, units, sensors, and faults in one sentence each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from device import Device, Time, backend_of, cameras
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.backends.backend import BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl_lerobot.backend import LeRobotBackend
from cbdsl_lerobot.rescaled import DEGREES, Rescaled, Scale
from tests.backends.conftest import robot_named, stage_named
from tests.conftest import ROOT, Checked

SIXAXIS = robot_named("sixaxis")
URDF = ROOT / "robots" / SIXAXIS.model
NAMES = Joints(SIXAXIS).names
LIMITS = [read_urdf(URDF).joints[name] for name in NAMES]
LOWER, UPPER = (np.array([getattr(j, end) for j in LIMITS]) for end in ("lower", "upper"))
FARTHEST = np.array([j.velocity for j in LIMITS]) / SIXAXIS.control.rate


def begun(device: Any, time: Time | None = None) -> LeRobotBackend:
    """Return a backend of the six-joint arm at the beginning of an episode."""
    backend = backend_of(device, SIXAXIS, URDF, time or Time())
    assert backend.reset(stage_named("sixaxis_bin"), None, np.random.default_rng(0)) == "still"
    return backend


def stepped(backend: LeRobotBackend, reference: np.ndarray) -> None:
    backend.apply(reference)
    backend.step()


def in_order(action: Mapping[str, float]) -> np.ndarray:
    return np.array([action[f"{name}.pos"] for name in NAMES])


references = st.lists(
    st.lists(st.floats(-1e6, 1e6), min_size=len(NAMES), max_size=len(NAMES)).map(np.array),
    min_size=1,
    max_size=8,
)


@given(references)
def test_actions_stay_within_limits_of_position_and_velocity(targets: list[np.ndarray]) -> None:
    device = Device(SIXAXIS)
    backend = begun(device)
    before = backend.observe().positions
    for target in targets:
        stepped(backend, target)
        action = in_order(device.actions[-1])
        assert (action >= LOWER).all() and (action <= UPPER).all()
        assert (abs(action - before) <= FARTHEST * (1 + 1e-9)).all()
        before = action
    # A reference that the limits allow is passed as it is.
    near = np.clip(before + 0.3 * FARTHEST, LOWER, UPPER)
    stepped(backend, near)
    assert in_order(device.actions[-1]) == pytest.approx(near)


def test_nothing_moves_before_the_first_step() -> None:
    device = Device(SIXAXIS, at=0.1)
    backend = begun(device)
    backend.apply(backend.observe().positions + 0.01)
    assert device.calls == ["connect"] and device.actions == []


def test_step_takes_one_control_period_and_reads_the_robot() -> None:
    time = Time()
    device = Device(SIXAXIS)
    backend = begun(device, time)
    before, began = backend.observe(), time.now
    assert (before.time, before.velocities.tolist()) == (0.0, [0.0] * len(NAMES))
    stepped(backend, before.positions + 0.5 * FARTHEST)
    after = backend.observe()
    assert time.now - began == pytest.approx(backend.control_period)
    assert after.time == pytest.approx(backend.control_period)
    assert after.positions == pytest.approx(0.5 * FARTHEST)
    assert after.velocities == pytest.approx(0.5 * FARTHEST * SIXAXIS.control.rate)
    device.values = {f"{name}.vel": 0.25 for name in NAMES}
    stepped(backend, after.positions)
    assert backend.observe().velocities.tolist() == [0.25] * len(NAMES), "measured ones count"


def test_halt_holds_the_measured_posture() -> None:
    device = Device(SIXAXIS)
    backend = begun(device)
    stepped(backend, FARTHEST)
    measured = {key: value - 0.002 for key, value in device.positions.items()}
    device.send_action = lambda action: device.actions.append(action)  # type: ignore[assignment]
    device.positions = measured
    stepped(backend, 2 * FARTHEST)
    backend.halt()
    assert device.actions[-1] == pytest.approx(measured)


def test_deadline_begins_after_the_first_tick() -> None:
    backend = begun(Device(SIXAXIS))
    assert backend.deadline is None
    stepped(backend, np.zeros(len(NAMES)))
    assert backend.deadline == backend.patience


def test_episode_on_a_late_robot_lasts_as_long_as_its_clock_says(checked: Checked) -> None:
    """Delay each observation by more than a control period."""
    device, time = Device(SIXAXIS), Time()
    backend = backend_of(device, SIXAXIS, URDF, time)

    def late(method: str) -> None:
        time.now += 0.012 if method == "get_observation" else 0.0

    device.fail = late
    runner = Runner(SIXAXIS, Kinematics(SIXAXIS, URDF), checked("poise", robot="sixaxis"), backend)
    began, observed = time.now, []
    result = runner.run(
        stage_named("sixaxis_bin"),
        0,
        observer=EpisodeListeners(on_tick=lambda tick: observed.append(tick.observation.time)),
    )
    assert result.ending.startswith("Done")
    assert result.sim_seconds == pytest.approx(observed[-1], abs=1e-6)
    assert result.sim_seconds == pytest.approx(time.now - began, abs=0.05)
    assert result.sim_seconds > 1.3 * result.ticks * backend.control_period


class Lacking:
    """Half of the interface."""

    def connect(self) -> None: ...
    def get_observation(self) -> dict[str, Any]:
        return {}


def slowly(time: Time) -> Callable[[str], None]:
    """Answer half a second late."""

    def wait(method: str) -> None:
        time.now += 0.5

    return wait


def test_object_without_the_interface_is_refused() -> None:
    with pytest.raises(BackendError, match="Lacking lacks the methods send_action, disconnect"):
        backend_of(Lacking(), SIXAXIS, URDF, Time())
    with pytest.raises(BackendError, match="LeRobotBackend has no method make"):
        LeRobotBackend(SIXAXIS, URDF)
    with pytest.raises(BackendError, match="no window"):
        LeRobotBackend(SIXAXIS, URDF, gui=True)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda p: p.pop("elbow.pos"), "device has no elbow.pos in its observation, which has: wa"),
        (lambda p: p.update({"elbow.pos": math.nan}), "device sends nan as elbow.pos: no finite"),
        (lambda p: p.update({"elbow.pos": None}), "device sends None as elbow.pos: no finite"),
        (lambda p: p.update({"waist.pos": 9.0}), "joint 'waist' is at 9, outside of its limits"),
    ],
)
def test_wrong_first_observation_is_reported_and_disconnects(
    change: Callable[[dict[str, Any]], object], message: str
) -> None:
    device = Device(SIXAXIS)
    change(device.positions)
    with pytest.raises(BackendError, match=message):
        backend_of(device, SIXAXIS, URDF, Time())
    assert device.calls == ["connect", "disconnect"] and device.actions == []


@pytest.mark.parametrize("method", ["connect", "get_observation", "send_action", "disconnect"])
def test_failing_method_ends_in_one_sentence_and_disconnects(method: str) -> None:
    device = Device(SIXAXIS)

    def fail(called: str) -> None:
        if called == method:
            raise OSError("no status packet")

    device.fail = fail
    with pytest.raises(BackendError, match=f"device.{method} failed: OSError: no status packet"):
        backend = begun(device)
        try:
            stepped(backend, np.zeros(len(NAMES)))
        except BackendError:
            backend.halt()
            raise
        finally:
            backend.close()
    assert device.calls == ["connect", "disconnect"]


def test_robot_that_answers_late_ends_the_episode() -> None:
    device, time = Device(SIXAXIS), Time()
    backend = begun(device, time)
    device.fail = slowly(time)
    with pytest.raises(BackendError, match=r"device took 0\.50 s to answer, and may take 0\.2 s"):
        stepped(backend, np.zeros(len(NAMES)))


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_reference_that_is_not_finite_is_never_sent(odd: float) -> None:
    device = Device(SIXAXIS)
    backend = begun(device)
    reference = np.zeros(len(NAMES))
    reference[2] = odd
    with pytest.raises(BackendError, match=f"the reference of joint '{NAMES[2]}' is not a finite"):
        stepped(backend, reference)
    assert device.actions == []


def test_robot_is_disconnected_once() -> None:
    device = Device(SIXAXIS)
    backend = begun(device)
    backend.close()
    backend.close()
    assert device.calls == ["connect", "disconnect"]


def felt(robot: RobotDocument, wrench: Mapping[str, float]) -> dict[str, float]:
    """Return the same wrench for each load cell, in the axes of its link."""
    axes = [f"{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"]
    return {
        f"{hand}.{finger}.{axis}": wrench.get(axis, 0.0)
        for hand, cells in robot.load_cells.items()
        for finger in cells
        for axis in axes
    }


def test_wrenches_are_turned_into_the_world(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics
) -> None:
    device = Device(dexter)
    device.values = {**cameras(dexter), **felt(dexter, {"force.x": 2.0, "torque.z": 0.1})}
    backend = backend_of(device, dexter, urdf, Time())
    observation = backend.observe()
    kinematics.update(observation.positions)
    for (hand, finger), wrench in observation.loads.items():
        axes = kinematics.frame(dexter.load_cells[hand][finger].link).rotation.T
        assert wrench == pytest.approx(np.array([*(2.0 * axes[0]), *(0.1 * axes[2])]))
    device.values.pop("right_hand.finger_1.force.x")
    with pytest.raises(BackendError, match=r"device has no right_hand\.finger_1\.force\.x"):
        backend_of(device, dexter, urdf, Time())


def test_images_come_at_the_rate_of_the_document(dexter: RobotDocument, urdf: Path) -> None:
    device = Device(dexter)
    device.values = {**cameras(dexter), **felt(dexter, {})}
    backend = backend_of(device, dexter, urdf, Time())
    shown = []
    for _ in range(round(dexter.control.rate)):
        observation = backend.observe()
        shown.append(bool(observation.images))
        if observation.images:
            assert set(observation.images) == set(dexter.cameras)
            late = max(0.0, observation.time - dexter.vision.latency)
            assert observation.exposed == pytest.approx(late)
        stepped(backend, observation.positions)
    assert shown[0] and sum(shown) == round(dexter.vision.rate)


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (None, "device sends nothing as camera 'left'"),
        (np.zeros((240, 320, 3)), r"sends float64 of shape \(240, 320, 3\) as camera 'left'"),
        (np.zeros((240, 320), dtype=np.uint8), r"uint8 of shape \(240, 320\) as camera 'left'"),
    ],
)
def test_wrong_image_is_reported(
    image: np.ndarray | None, message: str, dexter: RobotDocument, urdf: Path
) -> None:
    device = Device(dexter)
    device.values = {**cameras(dexter), **felt(dexter, {}), "left": image}
    if image is None:
        del device.values["left"]
    with pytest.raises(BackendError, match=message):
        backend_of(device, dexter, urdf, Time())


scales = st.builds(
    Scale,
    st.just("motor"),
    st.floats(1e-3, 10.0).flatmap(lambda size: st.sampled_from([size, -size])),
    st.floats(-100.0, 100.0),
)


@given(scales, st.floats(-10.0, 10.0))
def test_position_survives_both_ways_through_a_scale(scale: Scale, position: float) -> None:
    device = Device(SIXAXIS)
    device.positions = {}
    robot = Rescaled(device, {"joint": scale})
    robot.send_action({"joint.pos": position, "lamp": 1.0})
    (action,) = device.actions
    assert action.keys() == {"motor.pos", "lamp"}
    assert scale.unit * (action["motor.pos"] - scale.zero) == pytest.approx(position, abs=1e-6)
    observation = robot.get_observation()
    assert observation == {"joint.pos": pytest.approx(position, abs=1e-6), "lamp": 1.0}


def test_degrees_and_directions_become_radians() -> None:
    device = Device(SIXAXIS)
    device.positions = {"shoulder_pan.pos": 100.0, "shoulder_pan.vel": 10.0}
    robot = Rescaled(device, {"waist": Scale("shoulder_pan", -DEGREES, 10.0)})
    assert robot.get_observation() == pytest.approx(
        {"waist.pos": -math.pi / 2, "waist.vel": -math.pi / 18}
    )


@pytest.mark.parametrize("unit", [0.0, math.nan, math.inf])
def test_scale_that_cannot_be_inverted_is_refused(unit: float) -> None:
    with pytest.raises(ValueError, match="the scale of joint 'waist'"):
        Rescaled(Device(SIXAXIS), {"waist": Scale("waist", unit)})
