"""Hands in the kinematic world: they feel, push, hold and carry objects."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.backends.kinematic.grasp import STIFFNESS
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints
from tests.backends.conftest import URDF, contact_loads, made_stage, run
from tests.backends.kinematic.conftest import begin

FINGERS = ("finger_1", "finger_2", "finger_3")
BALL = {"form": {"shape": "ball", "radius": 0.06}, "mass": 0.25}
HELD_OUT = {"hand": "right_arm", "gap": 0.01, "held": True}


def test_joints_follow_their_references_within_speeds_and_limits(
    quiet: KinematicBackend, dexter: RobotDocument
) -> None:
    begin(quiet, made_stage({}))
    start = quiet.observe().positions
    goal = start + np.where(start > 0, -0.02, 0.02)
    quiet.apply(goal)
    quiet.step()
    observation = quiet.observe()
    assert observation.positions == pytest.approx(goal)
    assert observation.velocities == pytest.approx((goal - start) / quiet.control_period)
    pan = Joints(dexter).index["pan"]
    goal[pan] = 9.0
    quiet.apply(goal)
    quiet.step()
    assert quiet.observe().velocities[pan] == pytest.approx(4.0), "the URDF's limit"
    run(quiet, 2.0)
    assert quiet.observe().positions[pan] == pytest.approx(1.7), "the URDF's limit"


def test_window_of_the_kinematic_backend_is_refused(dexter: RobotDocument) -> None:
    with pytest.raises(BackendError, match="no window"):
        KinematicBackend(dexter, URDF, gui=True)


def _forces(backend: KinematicBackend) -> np.ndarray:
    loads = contact_loads(backend)
    return np.array([loads["right_hand", finger][:3] for finger in FINGERS])


def _flex(backend: KinematicBackend, force: float, seconds: float) -> None:
    """Flex the right fingers until they press with about ``force``, N; the thumb twice."""
    fingers = _fingers(backend)
    goal = force * np.array([0.53, 0.53, 1.0])
    reference = backend.observe().positions.copy()
    for _ in range(round(seconds / backend.control_period)):
        pressed = np.linalg.norm(_forces(backend), axis=1)
        speed = np.where(pressed > 0.05, np.clip(0.2 * (goal - pressed), -0.3, 0.3), 0.3)
        reference[fingers] = backend.observe().positions[fingers] + speed * backend.control_period
        backend.apply(reference)
        backend.step()


def _fingers(backend: KinematicBackend) -> np.ndarray:
    return backend._joints.pick([f"right_{finger}" for finger in FINGERS])


def test_load_cells_of_fingers_pressing_on_a_plate_point_into_it(quiet: KinematicBackend) -> None:
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


def _grasped(backend: KinematicBackend, released_after: float = 2.8) -> np.ndarray:
    """Take a ball that is held out; returns where it was."""
    context = {"things": ["ball"], "place": HELD_OUT, "released_after": released_after}
    begin(backend, made_stage(context, things={"ball": BALL}))
    start = backend.truth.pose("ball").position
    _flex(backend, force=5.0, seconds=3.0)
    return start


def test_load_cells_of_fingers_carrying_a_ball_sum_to_its_weight(quiet: KinematicBackend) -> None:
    start = _grasped(quiet)
    assert np.linalg.norm(quiet.truth.pose("ball").position - start) < 0.04, "it is carried"
    # Friction balances the forces along the normals, also of slanted fingertips.
    slanted = sum(STIFFNESS * each.depth * each.normal[2] for each in quiet.truth.contacts)
    assert abs(slanted) > 1.0
    assert _forces(quiet).sum(axis=0) == pytest.approx([0.0, 0.0, 0.25 * 9.81], abs=0.05)


def test_grasped_object_keeps_its_pose_in_the_hand(quiet: KinematicBackend) -> None:
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


def test_released_object_falls(quiet: KinematicBackend) -> None:
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


def test_fingers_stop_at_a_fixed_object(quiet: KinematicBackend) -> None:
    context = {"things": ["ball"], "place": HELD_OUT}
    begin(quiet, made_stage(context, things={"ball": BALL}))
    reference = quiet.observe().positions.copy()
    reference[_fingers(quiet)] = 2.4
    quiet.apply(reference)
    run(quiet, 3.0)
    assert (quiet.observe().positions[_fingers(quiet)] < 2.0).all()
    pressing = np.linalg.norm(_forces(quiet), axis=1)
    assert (pressing > 5).all() and (pressing < 60).all()
    # They return as soon as they are commanded to.
    reference[_fingers(quiet)] = 0.0
    quiet.apply(reference)
    run(quiet, 1.0)
    assert quiet.observe().positions[_fingers(quiet)] == pytest.approx(0.0)
    assert _forces(quiet) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_fingers_do_not_penetrate_a_held_object(backend: KinematicBackend, seed: int) -> None:
    rng = np.random.default_rng(seed)
    context = {"things": ["ball"], "place": {"hand": "right_arm", "gap": 0.02, "held": True}}
    ball = {**BALL, "form": {"shape": "ball", "radius": float(rng.uniform(0.07, 0.12))}}
    begin(backend, made_stage(context, things={"ball": ball}), seed)
    hand = backend._joints.pick(["right_spread", *(f"right_{finger}" for finger in FINGERS)])
    reference = backend.observe().positions.copy()
    for posture in rng.uniform(0.2, 2.4, (20, 4)):
        for _ in range(60):
            step = np.clip(posture - backend.observe().positions[hand], -0.01, 0.01)
            reference[hand] = backend.observe().positions[hand] + step
            backend.apply(reference)
            backend.step()
            assert all(contact.depth < 0.0201 for contact in backend.truth.contacts)


def test_finger_pushes_a_thing_away_until_friction_holds_it(quiet: KinematicBackend) -> None:
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
    for _ in range(round(1.0 / quiet.control_period)):
        reference[thumb] += 0.3 * quiet.control_period
        quiet.apply(reference)
        quiet.step()
    moved = quiet.truth.pose("ball").position - place
    assert moved @ inward > 0.005
    assert np.linalg.norm(_forces(quiet)[2]) < 1.0, "it rolls away under next to no force"


def test_object_on_a_carried_box_moves_along_and_others_rest(quiet: KinematicBackend) -> None:
    """Carry a box, with a ball on it, past another ball."""
    table = {"form": {"shape": "box", "size": [2, 2, 0.1]}, "position": [1.5, 0, -0.45]}
    box = {"form": {"shape": "box", "size": [0.2, 0.2, 0.1]}, "mass": 0.3}
    motion = {"speed": 0.1, "direction": 0.5}
    placed = {
        "upper": {"things": ["ball"], "place": {"on": "lower", "x": 0.02}},
        "lower": {"things": ["box"], "place": {"on": "table", "x": 1.0}, "motion": motion},
        "aside": {"things": ["ball"], "place": {"on": "table", "x": 1.0, "y": -0.4}},
    }
    fixtures, things = {"table": table}, {"box": box, "ball": BALL}
    begin(quiet, made_stage({"placed": placed}, fixtures=fixtures, things=things))
    start = {name: quiet.truth.pose(name).position for name in placed}
    run(quiet, 1.0)
    shift = {name: quiet.truth.pose(name).position - start[name] for name in placed}
    assert np.linalg.norm(shift["lower"]) == pytest.approx(0.1, abs=0.005)
    assert shift["upper"] == pytest.approx(shift["lower"])
    assert not shift["aside"].any()


def test_object_falls_after_its_support_is_removed(quiet: KinematicBackend) -> None:
    table = {"form": {"shape": "box", "size": [2, 2, 0.1]}, "position": [1.5, 0, -0.45]}
    box = {"form": {"shape": "box", "size": [0.2, 0.2, 0.1]}, "mass": 0.3}
    placed = {
        "lower": {"things": ["box"], "place": {"on": "table", "x": 1.0}, "removed_after": 0.5},
        "upper": {"things": ["ball"], "place": {"on": "lower"}},
    }
    fixtures, things = {"table": table}, {"box": box, "ball": BALL}
    begin(quiet, made_stage({"placed": placed}, fixtures=fixtures, things=things))
    start = quiet.truth.pose("upper").position
    run(quiet, 0.4)
    assert quiet.truth.pose("upper").position == pytest.approx(start)
    run(quiet, 0.6)
    assert quiet.truth.pose("upper").position == pytest.approx(start - [0, 0, 0.1], abs=1e-3)


def test_hand_takes_one_of_two_things(quiet: KinematicBackend) -> None:
    placed = {
        "held": {"things": ["ball"], "place": HELD_OUT, "released_after": 2.8},
        "other": {"things": ["ball"], "place": {"x": 0.6, "y": 0.5, "z": 0.5, "held": True}},
    }
    begin(quiet, made_stage({"placed": placed}, things={"ball": BALL}))
    start = {name: quiet.truth.pose(name).position for name in placed}
    _flex(quiet, force=5.0, seconds=3.0)
    assert np.linalg.norm(quiet.truth.pose("held").position - start["held"]) < 0.04
    assert quiet.truth.touched("held")
    assert not quiet.truth.touched("other")
    assert quiet.truth.pose("other").position == pytest.approx(start["other"])
