"""Visible objects, and their motion with the hands that hold them."""

from __future__ import annotations

from collections.abc import Container

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.observation import Cell, Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.regions.camera import heading
from cbdsl.sensing.vision.vision import SeenHeading

CHANNEL = "int_10"
STEP = 1e-6
SIZES = np.full(2, 0.01)  # m^2


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics) -> Signals:
    return Signals(dexter, kinematics, resources(dexter).values())


def facing(dexter: RobotDocument, signals: Signals) -> np.ndarray:
    """Return positions at which both hands face each other in front of the head."""
    positions = np.zeros(len(signals.joints))
    for name, effector in dexter.effectors.items():
        posture = "facing" if "facing" in effector.postures else effector.start
        if posture is not None:
            positions[signals.joints.of(name)] = effector.postures[posture]
    return positions


def feel(
    dexter: RobotDocument,
    signals: Signals,
    positions: np.ndarray,
    force: float,
    cells: Container[Cell] | None = None,
) -> None:
    """Update a tick in which all fingertips, or some, feel the same force."""
    loads = {
        (hand, finger): np.eye(6)[0] * (force if cells is None or (hand, finger) in cells else 0.0)
        for hand, fingers in dexter.load_cells.items()
        for finger in fingers
    }
    signals.update(Observation(0.0, positions, np.zeros_like(positions), loads, {}))


def see(dexter: RobotDocument, signals: Signals, position: np.ndarray) -> None:
    """Show something at a position to both cameras."""
    signals.vision.memories[CHANNEL].position = position
    signals.vision.memories[CHANNEL].radius = 0.1
    for name, camera in dexter.cameras.items():
        frame = signals.kinematics.frame(camera.link)
        angles = heading(frame.rotation.T @ (position - frame.position))
        signals.vision.headings[name, CHANNEL, 0] = SeenHeading(angles, 1)


def between(dexter: RobotDocument, signals: Signals) -> np.ndarray:
    centroid = signals.read(resources(dexter)["arms.centroid"])
    assert centroid is not None
    return centroid.value


def test_unheld_object_has_no_arm_in_its_jacobian(dexter: RobotDocument, signals: Signals) -> None:
    feel(dexter, signals, facing(dexter, signals), 0.0)
    see(dexter, signals, between(dexter, signals))
    pair = signals.read(resources(dexter)[f"cameras.{CHANNEL}"])
    assert pair is not None and pair.jacobian is not None
    head = signals.joints.of("head")
    assert np.any(pair.jacobian[:, head])
    assert not np.any(np.delete(pair.jacobian, head, axis=1))


def test_object_held_by_both_hands_moves_with_their_centroid(
    dexter: RobotDocument, signals: Signals
) -> None:
    """Compare the Jacobian of the headings through the arms by finite differences (Eq 3.42)."""
    positions, named = facing(dexter, signals), resources(dexter)
    arms = signals.joints.of("arms")

    def headings(at: np.ndarray) -> np.ndarray:
        feel(dexter, signals, at, 5.0)
        see(dexter, signals, between(dexter, signals))
        reading = signals.read(named[f"cameras.{CHANNEL}"])
        assert reading is not None
        return reading.value

    feel(dexter, signals, positions, 0.0)
    here = headings(positions)
    held = signals.read(named[f"cameras.{CHANNEL}"])
    seen = signals.read(named[f"stereo.{CHANNEL}"])
    centroid = signals.read(named["arms.centroid"])
    assert held is not None and seen is not None and centroid is not None
    assert held.jacobian is not None
    assert seen.jacobian == pytest.approx(centroid.jacobian)
    jacobian = held.jacobian.copy()
    for column in arms:
        moved = positions.copy()
        moved[column] += STEP
        assert jacobian[:, column] == pytest.approx((headings(moved) - here) / STEP, abs=1e-4)


def test_held_object_is_remembered_at_its_carried_place(
    dexter: RobotDocument, signals: Signals
) -> None:
    positions = facing(dexter, signals)
    feel(dexter, signals, positions, 0.0)
    feel(dexter, signals, positions, 5.0)
    start = between(dexter, signals)
    aside = np.array([0.0, 0.0, 0.02])
    see(dexter, signals, start + aside)
    positions, tips = positions.copy(), tips_of(signals)
    positions[signals.joints.of("arms")] += 0.05
    feel(dexter, signals, positions, 5.0)
    ways = tips_of(signals) - tips
    common = np.where((ways > 0).all(0) | (ways < 0).all(0), np.abs(ways).min(0), 0)
    assert np.linalg.norm(common) > 0.01
    remembered = signals.vision.memories[CHANNEL].position
    assert remembered == pytest.approx(start + aside + common * np.sign(ways[0]))


def tips_of(signals: Signals) -> np.ndarray:
    return np.array([signals.tips.point(arm).position for arm in ("left_arm", "right_arm")])


@pytest.mark.parametrize("fingers", [1, 2, 3])
def test_one_hand_holds_with_all_of_its_fingers(
    dexter: RobotDocument, signals: Signals, fingers: int
) -> None:
    positions = facing(dexter, signals)
    touching = [("right_hand", f"finger_{number + 1}") for number in range(fingers)]
    feel(dexter, signals, positions, 0.0)
    feel(dexter, signals, positions, 5.0, touching)
    tip = signals.tips.point("right_arm").position
    see(dexter, signals, tip)
    positions = positions.copy()
    positions[signals.joints.of("right_arm")] += 0.05
    feel(dexter, signals, positions, 5.0, touching)
    taken = signals.tips.point("right_arm").position
    assert np.linalg.norm(taken - tip) > 0.01
    remembered = signals.vision.memories[CHANNEL].position
    assert remembered == pytest.approx(taken if fingers == 3 else tip)


def between_fingers(signals: Signals) -> np.ndarray:
    """Return the middle between the fingertips of the right hand."""
    tips = [f"right_finger_{number}_tip" for number in (1, 2, 3)]
    middle: np.ndarray = signals.kinematics.origins((), tuple(tips)).mean(axis=0)
    return middle


RIGHT_FINGERS = [("right_hand", f"finger_{number}") for number in (1, 2, 3)]


def test_object_near_a_closed_hand_is_not_held(dexter: RobotDocument, signals: Signals) -> None:
    """Keep a goal in place, even if the fingers end up around it."""
    positions = facing(dexter, signals)
    feel(dexter, signals, positions, 0.0)
    goal = between_fingers(signals)
    away = positions.copy()
    away[signals.joints.of("right_arm")[0]] += 0.6
    feel(dexter, signals, away, 0.0)
    assert np.linalg.norm(between_fingers(signals) - goal) > 0.15
    see(dexter, signals, goal)
    feel(dexter, signals, away, 5.0, RIGHT_FINGERS)
    for share in np.linspace(0.0, 2.0, 21):
        feel(dexter, signals, away + share * (positions - away), 5.0, RIGHT_FINGERS)
    assert signals.vision.memories[CHANNEL].position == pytest.approx(goal)
    seen = signals.read(resources(dexter)[f"stereo.{CHANNEL}"])
    assert seen is not None
    assert not np.any(seen.jacobian)


def test_held_object_stays_held_and_its_neighbour_is_not(
    dexter: RobotDocument, signals: Signals
) -> None:
    """Hold, of two objects near the fingers, the one between them, with its parts."""
    positions = facing(dexter, signals)
    feel(dexter, signals, positions, 0.0)
    middle = between_fingers(signals)
    things = signals.vision.instances[CHANNEL].memories
    for memory, offset, radius in zip(
        things, (0.005, 0.065, 0.02), (0.03, 0.03, 0.01), strict=False
    ):
        memory.position, memory.radius = middle + np.array([0.0, 0.0, offset]), radius
    before = [memory.position.copy() for memory in things[:3] if memory.position is not None]
    feel(dexter, signals, positions, 5.0, RIGHT_FINGERS)
    moved = positions.copy()
    moved[signals.joints.of("right_arm")[0]] += 0.1
    feel(dexter, signals, moved, 5.0, RIGHT_FINGERS)
    shifts = [
        np.linalg.norm(memory.position - place)
        for memory, place in zip(things, before, strict=False)
        if memory.position is not None
    ]
    assert [shift > 0.01 for shift in shifts] == [True, False, True]


def test_object_far_from_the_hands_is_not_held(dexter: RobotDocument, signals: Signals) -> None:
    positions, far = facing(dexter, signals), np.array([0.6, 0.0, -0.42])
    feel(dexter, signals, positions, 0.0)
    feel(dexter, signals, positions, 5.0)
    see(dexter, signals, far)
    seen = signals.read(resources(dexter)[f"stereo.{CHANNEL}"])
    assert seen is not None
    assert not np.any(seen.jacobian)


@pytest.mark.parametrize("hidden_from", [("left",), ("right",), ("left", "right")])
def test_held_object_keeps_its_headings_behind_an_arm(
    dexter: RobotDocument, signals: Signals, hidden_from: tuple[str, ...]
) -> None:
    """Keep the headings and Jacobians of the visible object; without the hold there are none."""
    positions, pair = facing(dexter, signals), resources(dexter)[f"cameras.{CHANNEL}"]
    feel(dexter, signals, positions, 0.0)
    feel(dexter, signals, positions, 5.0)
    see(dexter, signals, between(dexter, signals))
    seen = signals.read(pair)
    for name in hidden_from:
        del signals.vision.headings[name, CHANNEL, 0]
    hidden = signals.read(pair)
    assert seen is not None and hidden is not None
    assert hidden.value == pytest.approx(seen.value)
    assert hidden.jacobian == pytest.approx(seen.jacobian)
    feel(dexter, signals, positions, 0.0)
    assert signals.read(pair) is None


def test_held_object_out_of_view_has_no_headings(dexter: RobotDocument, signals: Signals) -> None:
    positions = facing(dexter, signals)
    positions[signals.joints.of("head")] += 0.8
    feel(dexter, signals, positions, 0.0)
    feel(dexter, signals, positions, 5.0)
    signals.vision.memories[CHANNEL].position = between(dexter, signals)
    assert signals.read(resources(dexter)[f"cameras.{CHANNEL}"]) is None


def test_lines_of_sight_that_do_not_meet_are_no_pair(
    dexter: RobotDocument, signals: Signals
) -> None:
    feel(dexter, signals, facing(dexter, signals), 0.0)
    see(dexter, signals, np.array([0.9, 0.0, 0.0]))
    for name, outwards in (("left", 0.8), ("right", -0.8)):
        angles = np.array([outwards, 0.0])
        signals.vision.headings[name, CHANNEL, 0] = SeenHeading(angles, 1)
    assert signals.read(resources(dexter)[f"cameras.{CHANNEL}"]) is None


@pytest.mark.parametrize("alone", ["left", "right"])
def test_cyclopean_heading_is_the_mean_of_both_cameras(
    dexter: RobotDocument, signals: Signals, alone: str
) -> None:
    """Track an object that one camera loses by the other alone."""
    named = resources(dexter)
    feel(dexter, signals, facing(dexter, signals), 0.0)
    see(dexter, signals, between(dexter, signals))
    left, right, both = (
        signals.read(named[f"{camera}.{CHANNEL}"]) for camera in ("left", "right", "cyclopean")
    )
    assert left is not None and right is not None and both is not None
    assert not np.allclose(left.value, right.value)
    assert both.value == pytest.approx((left.value + right.value) / 2)
    assert left.jacobian is not None and right.jacobian is not None
    assert both.jacobian == pytest.approx((left.jacobian + right.jacobian) / 2)
    (other,) = {"left", "right"} - {alone}
    del signals.vision.headings[other, CHANNEL, 0]
    seen = signals.read(named[f"cyclopean.{CHANNEL}"])
    expected = left if alone == "left" else right
    assert seen is not None and seen.value == pytest.approx(expected.value)


def test_cameras_are_placed_in_the_first_one_s_frame(
    dexter: RobotDocument, signals: Signals
) -> None:
    """Place the right one beside it for every direction of the head."""
    positions = facing(dexter, signals)
    positions[:2] = 0.4, -0.3
    feel(dexter, signals, positions, 0.0)
    first, second = signals.sight.cameras()
    np.testing.assert_allclose(first.position, 0.0, atol=1e-12)
    np.testing.assert_allclose(first.rotation, np.eye(3), atol=1e-12)
    left, right = (signals.kinematics.frame(each.link) for each in dexter.cameras.values())
    np.testing.assert_allclose(left.rotation @ second.position + left.position, right.position)
    np.testing.assert_allclose(left.rotation @ second.rotation, right.rotation, atol=1e-12)
