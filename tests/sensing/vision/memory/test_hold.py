"""Held objects move with the hands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from cbdsl.documents.robot import Regions, RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.table import records_of
from cbdsl.sensing.vision.memory.hold import Content, Hold, find_hold, held_jacobian
from cbdsl.sensing.vision.memory.memory import PositionMemory

LEFT, ARM = HANDS = "left_arm", "right_arm"
STEP = 1e-6


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics) -> Signals:
    return Signals(dexter, kinematics, ())


def hold_of(signals: Signals, arms: Sequence[str], positions: np.ndarray) -> Hold | None:
    """Return the hold if the hands of some arms feel contact with all of their fingers."""
    signals.kinematics.update(positions)
    signals.kinematics.place()
    feeling = np.array([arm in arms for arm in HANDS for _ in range(3)])
    return found(signals, feeling)


def found(signals: Signals, feeling: np.ndarray) -> Hold | None:
    tips = records_of([signals.tips.part(arm) for arm in HANDS])
    position, rotation, cells = np.empty(3), np.empty((3, 3)), np.array([[0, 3], [3, 6]])
    hands = find_hold(signals.kinematics.frames, tips, cells, feeling, position, rotation)
    holding = [arm for i, arm in enumerate(HANDS) if hands >> i & 1]
    own = np.array([signals.tips.point(arm).position for arm in holding])
    return Hold(hands, position, rotation, own) if hands else None


def random_posture(kinematics: Kinematics, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(kinematics.lower, kinematics.upper)


def motions(signals: Signals, arms: Sequence[str]) -> np.ndarray:
    """Return joint displacements that move all tips of some arms alike, as rows."""
    jacobians = [signals.tips.point(arm).jacobian[:3] for arm in arms]
    if len(jacobians) == 1:
        return np.eye(jacobians[0].shape[1])
    ways = np.linalg.pinv(np.concatenate(jacobians)) @ np.tile(np.eye(3), (len(jacobians), 1))
    return np.asarray(ways.T)


@pytest.mark.parametrize("arms", [(ARM,), HANDS])
def test_jacobian_is_the_derivative_of_where_a_thing_is_carried(
    signals: Signals, kinematics: Kinematics, arms: Sequence[str]
) -> None:
    rng = np.random.default_rng(3)
    for _ in range(5):
        positions = random_posture(kinematics, rng)
        before = hold_of(signals, arms, positions)
        assert before is not None
        position = before.position + rng.uniform(-0.15, 0.15, 3)
        jacobian = held_jacobian([signals.tips.point(arm) for arm in arms], position)
        for motion in motions(signals, arms):
            after = hold_of(signals, arms, positions + STEP * motion)
            assert after is not None
            displacement = after.displace(before, before, position)
            assert jacobian @ motion == pytest.approx(displacement / STEP, abs=1e-5)


def between_hands(left: Sequence[float], right: Sequence[float]) -> Hold:
    tips = np.array([left, right])
    return Hold(3, tips.mean(axis=0), np.eye(3), tips)


def test_motion_of_a_single_hand_slips_along_an_object_held_by_several() -> None:
    begun = between_hands((0.5, 0.2, 0.0), (0.5, -0.2, 0.0))
    after = between_hands((0.51, 0.2, -0.02), (0.53, -0.2, 0.05))
    place = np.array([0.5, 0.0, 0.0])
    assert after.displace(begun, begun, place) == pytest.approx([0.01, 0.0, 0.0])


def test_trembling_hands_keep_the_whole_displacement() -> None:
    """They take the object as far as hands at rest."""
    begun = before = between_hands((0.5, 0.2, 0.0), (0.5, -0.2, 0.0))
    place, rng = np.zeros(3), np.random.default_rng(5)
    before_it = np.array([(0.5, 0.2, 0.0), (0.5, -0.2, 0.0)])
    for number in range(1, 101):
        left, right = 1e-3 * rng.normal(size=(2, 3)) + before_it + (1e-3 * number, 0.0, 0.0)
        after = between_hands(left, right)
        place = place + after.displace(begun, before, place)
        before = after
    assert place == pytest.approx([0.1, 0.0, 0.0], abs=4e-3)


def test_object_held_by_one_hand_keeps_its_place_in_the_hand(
    signals: Signals, kinematics: Kinematics
) -> None:
    rng = np.random.default_rng(4)
    before, after = (hold_of(signals, (ARM,), random_posture(kinematics, rng)) for _ in range(2))
    assert before is not None and after is not None
    position = before.position + rng.uniform(-0.15, 0.15, 3)
    carried = position + after.displace(before, before, position)
    own = [
        hold.rotation.T @ (place - hold.position)
        for hold, place in ((before, position), (after, carried))
    ]
    assert own[1] == pytest.approx(own[0])


@pytest.mark.parametrize("feeling", range(64))
def test_one_hand_holds_with_all_of_its_fingers_and_several_with_any(
    signals: Signals, kinematics: Kinematics, feeling: int
) -> None:
    kinematics.update(random_posture(kinematics, np.random.default_rng(feeling)))
    felt = np.array([bool(feeling >> cell & 1) for cell in range(6)])
    tips = [signals.tips.point(arm).position for arm in HANDS]
    left, right = felt[:3], felt[3:]
    hold = found(signals, felt)
    if left.any() and right.any():
        assert hold is not None and hold.hands == 3
        assert hold.position == pytest.approx(np.mean(tips, axis=0))
        np.testing.assert_array_equal(hold.rotation, np.eye(3))
    elif left.all() or right.all():
        hand = 0 if left.all() else 1
        assert hold is not None and hold.hands == 1 << hand
        assert hold.position == pytest.approx(tips[hand])
        assert hold.rotation == pytest.approx(signals.tips.frame(HANDS[hand]).rotation)
    else:
        assert hold is None


def thing(x: float, radius: float = 0.05, since: float = 1.0) -> PositionMemory:
    """Return an object at some place on a line, m."""
    made = PositionMemory(Regions())
    made.position, made.radius, made.since = np.array([x, 0.0, 0.0]), radius, since
    return made


def test_object_between_the_fingers_is_held_with_its_parts() -> None:
    """Decide on the deepest object first, and on others by whether they are a part of it."""
    content = Content(lambda: np.zeros(3))
    one, part, beside = thing(0.04), thing(-0.019, 0.005), thing(0.101, 0.07)
    unseen = thing(0.0)
    unseen.position = None
    content.begin([beside, part, unseen, one])
    assert [content.holds(each) for each in (one, part, beside, unseen)] == [
        True, True, False, False
    ]  # fmt: skip


@pytest.mark.parametrize(("x", "held"), [(0.079, True), (0.081, False)])
def test_hold_is_decided_within_3_cm_when_it_begins(x: float, held: bool) -> None:
    content, one = Content(lambda: np.zeros(3)), thing(x)
    content.begin([one])
    assert content.holds(one) is held
    one.position = np.array([0.0 if not held else 9.0, 0.0, 0.0])
    assert content.holds(one) is held, "it was decided when the hold began"


def test_newly_discovered_object_is_decided_again() -> None:
    content, one = Content(lambda: np.zeros(3)), thing(9.0)
    content.begin([one])
    one.position, one.since = np.zeros(3), 2.0
    assert content.holds(one)


@pytest.mark.parametrize(("x", "held"), [(0.059, True), (0.061, False)])
def test_part_of_a_held_object_is_within_its_radius_and_1_cm(x: float, held: bool) -> None:
    content, one, other = Content(lambda: np.zeros(3)), thing(0.0), thing(x, 0.01)
    content.begin([one, other])
    assert content.holds(one) and content.holds(other) is held
    content.begin([])
    assert content.holds(thing(0.079)), "with nothing held it is what is between the fingers"


def test_forgotten_held_object_does_not_decide_about_the_next() -> None:
    content, one = Content(lambda: np.zeros(3)), thing(0.0)
    content.begin([one])
    one.position = None
    assert not content.holds(one)
    assert content.holds(thing(0.05)), "it is between the fingers"
    assert not content.holds(thing(0.2))


def test_lost_object_that_is_seen_elsewhere_is_not_held() -> None:
    content, one = Content(lambda: np.zeros(3)), thing(0.0)
    content.begin([one])
    assert content.holds(one)
    one.position, one.since = np.array([0.3, 0.0, 0.0]), 2.0
    assert not content.holds(one)
