"""The backend's contract, and what hands do to things: they feel, push, hold and carry them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.backends.kinematic.grasp import STIFFNESS
from cbdsl.backends.scenery import Witness
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.observation import Observation
from tests.backends.bullet.conftest import LIBRARY, ROOT, URDF, made_stage, stage_named, with_vision
from tests.backends.kinematic.conftest import begin, run

STAGES = LIBRARY.names(StageDocument)
FINGERS = ("finger_1", "finger_2", "finger_3")
BALL = {"form": {"shape": "ball", "radius": 0.06}, "mass": 0.25}
HELD_OUT = {"hand": "right_arm", "gap": 0.01, "held": True}


def robot_named(name: str) -> RobotDocument:
    return LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document


def _episode(backend: KinematicBackend, seed: int) -> list[bytes]:
    """All that is observed of an episode in which all joints move."""
    begin(backend, stage_named("noisy_right"), seed)
    seen = []
    reference = backend.observe().positions
    for _ in range(24):
        seen.append(_bytes(backend.observe()))
        reference = reference + 0.01
        backend.apply(reference)
        backend.step()
    return seen


def _bytes(observation: Observation) -> bytes:
    arrays = [observation.positions, observation.velocities, *observation.loads.values()]
    regions = repr({camera: dict(found) for camera, found in observation.regions.items()})
    return b"".join(np.ascontiguousarray(array).tobytes() for array in arrays) + regions.encode()


def test_same_seed_same_bytes_whatever_ran_before(
    backend: KinematicBackend, dexter: RobotDocument
) -> None:
    first = _episode(backend, 3)
    assert _episode(backend, 4) != first
    assert _episode(backend, 3) == first
    assert _episode(KinematicBackend(dexter, URDF), 3) == first


def test_sensor_noise_does_not_depend_on_who_else_draws(backend: KinematicBackend) -> None:
    rng = np.random.default_rng(0)
    backend.reset(stage_named("absent"), None, rng)
    state = rng.bit_generator.state
    backend.step()
    assert rng.bit_generator.state == state


def test_an_observation_does_not_change_with_the_next_step(backend: KinematicBackend) -> None:
    begin(backend, stage_named("table_right"))
    before = backend.observe()
    kept = _bytes(before)
    backend.apply(before.positions + 0.05)
    backend.step()
    assert _bytes(before) == kept
    assert _bytes(backend.observe()) != kept


@pytest.mark.parametrize("rate", [30.0, 25.0, 15.0, 7.0])
def test_ideal_cameras_look_at_their_rate(dexter: RobotDocument, rate: float) -> None:
    backend = KinematicBackend(with_vision(dexter, rate=rate), URDF)
    begin(backend, stage_named("absent"))
    times = []
    for _ in range(round(dexter.control.rate)):
        observation = backend.observe()
        assert not observation.images
        if observation.regions:
            assert set(observation.regions) == set(dexter.cameras)
            times.append(observation.time)
        backend.step()
    assert times[0] == 0
    assert len(times) == rate
    assert np.diff(times) == pytest.approx(1 / rate, abs=backend.control_period + 1e-9)


@pytest.mark.parametrize("name", STAGES)
def test_every_context_of_every_shipped_stage_can_begin(name: str) -> None:
    stage = stage_named(name)
    robot = robot_named(stage.robot)
    backend = KinematicBackend(robot, ROOT / "robots" / robot.model)
    for context, content in stage.contexts.items():
        assert backend.reset(stage, context, np.random.default_rng(1)) == context
        assert isinstance(backend, Witness)
        shown = set(backend.truth.names()) - set(stage.fixtures)
        assert len(shown) == bool(content.things)
        assert shown <= set(content.things)
        backend.step()
        assert not any(backend.truth.touched(thing) for thing in shown)
        for thing in backend.truth.names():
            assert backend.truth.parts(thing)


def test_joints_follow_their_references_within_speeds_and_limits(
    backend: KinematicBackend, dexter: RobotDocument
) -> None:
    begin(backend, made_stage({}))
    start = backend.observe().positions
    goal = start + np.where(start > 0, -0.02, 0.02)
    backend.apply(goal)
    backend.step()
    observation = backend.observe()
    assert observation.positions == pytest.approx(goal)
    assert observation.velocities == pytest.approx((goal - start) * dexter.control.rate)
    pan = Joints(dexter).index["pan"]
    goal[pan] = 9.0
    backend.apply(goal)
    backend.step()
    assert backend.observe().velocities[pan] == pytest.approx(4.0), "the URDF's limit"
    run(backend, 2.0)
    assert backend.observe().positions[pan] == pytest.approx(1.7), "the URDF's limit"


def test_what_does_not_fit_is_refused(
    backend: KinematicBackend, dexter: RobotDocument, tmp_path: Path
) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(BackendError, match=r"'nowhere'.*only"):
        backend.reset(made_stage({}), "nowhere", rng)
    with pytest.raises(BackendError, match="no actuated joint 'elbow'"):
        backend.reset(made_stage({"joints": {"elbow": 0}}), None, rng)
    with pytest.raises(BackendError, match="thing 'cup'; there is: none"):
        backend.reset(made_stage({"things": ["cup"], "place": {"z": 0}}), None, rng)
    place: dict[str, Any] = {"things": ["ball"], "place": {"on": "shelf"}}
    with pytest.raises(BackendError, match="fixture 'shelf'"):
        backend.reset(made_stage(place, things={"ball": BALL}), None, rng)
    place = {"things": ["ball"], "place": {"hand": "head", "gap": 0.02}}
    with pytest.raises(BackendError, match="'head', which has no tip"):
        backend.reset(made_stage(place, things={"ball": BALL}), None, rng)
    with pytest.raises(BackendError, match="no window"):
        KinematicBackend(dexter, URDF, gui=True)
    with pytest.raises(BackendError, match=r"none\.urdf"):
        KinematicBackend(dexter, tmp_path / "none.urdf")


@pytest.mark.parametrize(
    ("written", "instead", "complaint"),
    [
        ('name="pan"', 'name="neck"', "no revolute joint 'pan'"),
        ('"left_camera"', '"x"', "no link 'left_camera'"),
        ('"torso"', '"trunk"', "base 'torso'.*'trunk'"),
        ("</robot>", "", "cannot be read"),
    ],
)
def test_a_model_that_does_not_fit_is_refused(
    dexter: RobotDocument, tmp_path: Path, written: str, instead: str, complaint: str
) -> None:
    text = URDF.read_text()
    assert written in text
    urdf = tmp_path / "broken.urdf"
    urdf.write_text(text.replace(written, instead))
    with pytest.raises(BackendError, match=complaint):
        KinematicBackend(dexter, urdf)


def _forces(backend: KinematicBackend) -> np.ndarray:
    loads = backend.observe().loads
    return np.array([loads["right_hand", finger][:3] for finger in FINGERS])


def _flex(backend: KinematicBackend, force: float, seconds: float) -> None:
    """Flex the right fingers until they press with about ``force``, N; the thumb twice."""
    fingers = _fingers(backend)
    goal = force * np.array([0.53, 0.53, 1.0])
    reference = backend.observe().positions.copy()
    for _ in range(round(seconds / backend.control_period)):
        pressed = np.linalg.norm(_forces(backend), axis=1)
        speed = np.where(pressed > 0.05, np.clip(0.6 * (goal - pressed), -0.3, 0.3), 0.3)
        reference[fingers] = backend.observe().positions[fingers] + speed * backend.control_period
        backend.apply(reference)
        backend.step()


def _fingers(backend: KinematicBackend) -> np.ndarray:
    return backend._joints.pick([f"right_{finger}" for finger in FINGERS])


def test_fingers_that_press_on_a_plate_push_it_away(quiet: KinematicBackend) -> None:
    begin(quiet, made_stage({}))
    palm = quiet.truth.link_pose("right_palm").position
    plate = {
        "form": {"shape": "box", "size": [0.5, 0.5, 0.02]},
        "position": [palm[0], palm[1], palm[2] - 0.09],
    }
    begin(quiet, made_stage({}, fixtures={"plate": plate}))
    _flex(quiet, force=2.0, seconds=3.0)
    assert quiet.truth.touched("plate")
    forces = _forces(quiet)
    assert np.linalg.norm(forces, axis=1) == pytest.approx([1.06, 1.06, 2.0], abs=0.05)
    assert forces[:, :2] == pytest.approx(0.0, abs=1e-9), "there is no friction on a fixture"
    assert (forces[:, 2] < 0).all(), "the palm faces down, so fingertips push down"


def _grasped(backend: KinematicBackend, released_after: float = 2.5) -> np.ndarray:
    """Take a ball that is held out; returns where it was."""
    context = {"things": ["ball"], "place": HELD_OUT, "released_after": released_after}
    begin(backend, made_stage(context, things={"ball": BALL}))
    start = backend.truth.pose("ball").position
    _flex(backend, force=5.0, seconds=3.0)
    return start


def test_fingers_that_carry_a_ball_exert_its_weight_upward(quiet: KinematicBackend) -> None:
    start = _grasped(quiet)
    assert np.linalg.norm(quiet.truth.pose("ball").position - start) < 0.04, "it is carried"
    assert _forces(quiet).sum(axis=0)[2] == pytest.approx(
        sum(STIFFNESS * each.depth * each.normal[2] for each in quiet.truth.contacts) + 0.25 * 9.81,
        abs=0.05,
    )


def test_what_is_grasped_goes_where_the_hand_goes(quiet: KinematicBackend) -> None:
    _grasped(quiet)
    palm, ball = quiet.truth.link_pose("right_palm"), quiet.truth.pose("ball")
    before = palm.rotation.T @ (ball.position - palm.position)
    reference = quiet.observe().positions.copy()
    arm = quiet._joints.of("right_arm")
    for _ in range(60):
        reference[arm] -= 0.01 * np.sign(reference[arm])
        quiet.apply(reference)
        quiet.step()
    moved, carried = quiet.truth.link_pose("right_palm"), quiet.truth.pose("ball")
    assert np.linalg.norm(moved.position - palm.position) > 0.1
    after = moved.rotation.T @ (carried.position - moved.position)
    assert after == pytest.approx(before, abs=1e-3)
    assert moved.rotation.T @ carried.rotation == pytest.approx(
        palm.rotation.T @ ball.rotation, abs=1e-6
    )


def test_what_is_let_go_falls(quiet: KinematicBackend) -> None:
    _grasped(quiet)
    height = quiet.truth.pose("ball").position[2]
    reference = quiet.observe().positions.copy()
    reference[_fingers(quiet)] = 0.0
    quiet.apply(reference)
    run(quiet, 1.0)
    assert not quiet.truth.contacts
    assert quiet.truth.pose("ball").position[2] < height - 2


def test_too_weak_a_grasp_does_not_hold(quiet: KinematicBackend) -> None:
    context = {"things": ["ball"], "place": HELD_OUT, "released_after": 4.0}
    begin(quiet, made_stage(context, things={"ball": BALL}))
    _flex(quiet, force=0.3, seconds=3.9)
    assert len(quiet.truth.contacts) == 3
    height = quiet.truth.pose("ball").position[2]
    _flex(quiet, force=0.3, seconds=1.0)
    assert quiet.truth.pose("ball").position[2] < height - 0.5


def test_fingers_are_held_back_by_what_they_cannot_push_away(quiet: KinematicBackend) -> None:
    context = {"things": ["ball"], "place": HELD_OUT}
    begin(quiet, made_stage(context, things={"ball": BALL}))
    reference = quiet.observe().positions.copy()
    reference[_fingers(quiet)] = 2.4
    quiet.apply(reference)
    run(quiet, 3.0)
    assert (quiet.observe().positions[_fingers(quiet)] < 2.0).all()
    pressing = np.linalg.norm(_forces(quiet), axis=1)
    assert (pressing > 5).all() and (pressing < 60).all()
    # And they come back as soon as they want to.
    reference[_fingers(quiet)] = 0.0
    quiet.apply(reference)
    run(quiet, 1.0)
    assert quiet.observe().positions[_fingers(quiet)] == pytest.approx(0.0)
    assert _forces(quiet) == pytest.approx(0.0, abs=1e-3)


def test_a_finger_pushes_a_thing_away_until_friction_holds_it(quiet: KinematicBackend) -> None:
    begin(quiet, made_stage({}))
    tip = quiet.truth.link_pose("right_finger_3_tip").position
    palm = quiet.truth.link_pose("right_palm").position
    inward = (palm - tip) * [1, 1, 0]
    inward /= np.linalg.norm(inward)
    place = tip + 0.07 * inward
    shelf = {
        "form": {"shape": "box", "size": [0.8, 0.8, 0.02]},
        "position": [*place[:2].tolist(), float(tip[2]) - 0.06],
    }
    ball = {**BALL, "form": {"shape": "ball", "radius": 0.05}}
    context = {"things": ["ball"], "place": {"on": "shelf", "x": place[0], "y": place[1]}}
    stage = made_stage(context, things={"ball": ball}, fixtures={"shelf": shelf})
    begin(quiet, stage)
    reference = quiet.observe().positions.copy()
    thumb = quiet._joints.index["right_finger_3"]
    for _ in range(60):
        reference[thumb] += 0.3 * quiet.control_period
        quiet.apply(reference)
        quiet.step()
    moved = quiet.truth.pose("ball").position - place
    assert moved @ inward > 0.005
    assert np.linalg.norm(_forces(quiet)[2]) < 1.0, "it rolls away under next to no force"


def test_a_carried_thing_is_left_alone_once_a_finger_touches_it(quiet: KinematicBackend) -> None:
    begin(quiet, made_stage({}))
    tip = quiet.truth.link_pose("right_finger_1_tip").position
    shelf = {
        "form": {"shape": "box", "size": [0.8, 0.8, 0.02]},
        "position": [tip[0], tip[1], tip[2] - 0.04],
    }
    block = {"form": {"shape": "box", "size": [0.08, 0.08, 0.08]}, "mass": 0.3}
    context = {
        "things": ["block"],
        "place": {"on": "shelf", "x": tip[0], "y": tip[1] + 0.2},
        "motion": {"speed": 0.3, "direction": -np.pi / 2},
    }
    begin(quiet, made_stage(context, fixtures={"shelf": shelf}, things={"block": block}))
    start = quiet.truth.pose("block").position
    run(quiet, 0.2)
    moved = quiet.truth.pose("block").position - start
    assert moved == pytest.approx([0, -0.06, 0], abs=1e-6)
    run(quiet, 0.8)
    assert quiet.truth.touched("block")
    assert np.linalg.norm(quiet.truth.velocity("block")) == 0.0


def test_a_thing_is_taken_away_in_time(quiet: KinematicBackend) -> None:
    context = {"things": ["ball"], "place": {"z": -0.1}, "removed_after": 0.5}
    begin(quiet, made_stage(context, things={"ball": BALL}))
    run(quiet, 0.5)
    assert quiet.truth.names() == ("ball",)
    quiet.step()
    assert quiet.truth.names() == ()
    run(quiet, 0.1)
