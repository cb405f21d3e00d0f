"""What hands hold moves with them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.hold import Hold, find_hold, held_jacobian
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table import records_of

LEFT, ARM = HANDS = "left_arm", "right_arm"
STEP = 1e-6


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics) -> Signals:
    return Signals(dexter, kinematics, ())


def hold_of(signals: Signals, arms: Sequence[str], positions: np.ndarray) -> Hold | None:
    """What is found where the hands of some arms feel contact with all of their fingers."""
    signals.kinematics.update(positions)
    signals.kinematics.place()
    feeling = np.array([arm in arms for arm in HANDS for _ in range(3)])
    return found(signals, feeling)


def found(signals: Signals, feeling: np.ndarray) -> Hold | None:
    tips = records_of([signals.tips.part(arm) for arm in HANDS])
    position, rotation, cells = np.empty(3), np.empty((3, 3)), np.array([[0, 3], [3, 6]])
    hands = find_hold(signals.kinematics.frames, tips, cells, feeling, position, rotation)
    return Hold(hands, position, rotation) if hands else None


def random_posture(kinematics: Kinematics, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(kinematics.lower, kinematics.upper)


@pytest.mark.parametrize("arms", [(ARM,), HANDS])
def test_the_jacobian_is_the_derivative_of_where_a_thing_is_carried(
    signals: Signals, kinematics: Kinematics, arms: Sequence[str]
) -> None:
    rng = np.random.default_rng(3)
    for _ in range(5):
        positions = random_posture(kinematics, rng)
        before = hold_of(signals, arms, positions)
        assert before is not None
        position = before.position + rng.uniform(-0.15, 0.15, 3)
        jacobian = held_jacobian([signals.tips.point(arm) for arm in arms], position)
        for column in range(len(positions)):
            moved = positions.copy()
            moved[column] += STEP
            after = hold_of(signals, arms, moved)
            assert after is not None
            displacement = after.displace(before, position)
            assert jacobian[:, column] == pytest.approx(displacement / STEP, abs=1e-5)


def test_what_one_hand_holds_keeps_its_place_in_the_hand(
    signals: Signals, kinematics: Kinematics
) -> None:
    rng = np.random.default_rng(4)
    before, after = (hold_of(signals, (ARM,), random_posture(kinematics, rng)) for _ in range(2))
    assert before is not None and after is not None
    position = before.position + rng.uniform(-0.15, 0.15, 3)
    carried = position + after.displace(before, position)
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
