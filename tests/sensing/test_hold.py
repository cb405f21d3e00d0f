"""What hands hold moves with them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.hold import Hold
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import Centroid, Tip

ARM = "right_arm"
STEP = 1e-6


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics) -> Signals:
    return Signals(dexter, kinematics, ())


def hold_of_one(signals: Signals, positions: np.ndarray) -> Hold:
    signals.kinematics.update(positions)
    return Hold.of_one(ARM, signals.tips.read(Tip(ARM, "pose")))


def hold_of_both(signals: Signals, positions: np.ndarray) -> Hold:
    signals.kinematics.update(positions)
    return Hold.of_several(("left_arm", ARM), signals.tips.centroid(Centroid("arms")))


def random_posture(kinematics: Kinematics, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(kinematics.lower, kinematics.upper)


@pytest.mark.parametrize("made", [hold_of_one, hold_of_both])
def test_the_jacobian_is_the_derivative_of_where_a_thing_is_carried(
    signals: Signals, kinematics: Kinematics, made: Callable[[Signals, np.ndarray], Hold]
) -> None:
    rng = np.random.default_rng(3)
    for _ in range(5):
        positions = random_posture(kinematics, rng)
        before = made(signals, positions)
        position = before.position + rng.uniform(-0.15, 0.15, 3)
        jacobian = before.jacobian(position).copy()
        for column in range(len(positions)):
            moved = positions.copy()
            moved[column] += STEP
            displacement = made(signals, moved).moved(before, position)
            assert jacobian[:, column] == pytest.approx(displacement / STEP, abs=1e-5)


def test_what_one_hand_holds_keeps_its_place_in_the_hand(
    signals: Signals, kinematics: Kinematics
) -> None:
    rng = np.random.default_rng(4)
    before, after = (hold_of_one(signals, random_posture(kinematics, rng)) for _ in range(2))
    position = before.position + rng.uniform(-0.15, 0.15, 3)
    carried = position + after.moved(before, position)
    own = [
        hold.rotation.T @ (place - hold.position)
        for hold, place in ((before, position), (after, carried))
    ]
    assert own[1] == pytest.approx(own[0])
