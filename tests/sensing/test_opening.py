"""Opening and centre of a hand, against the frames of its fingertips."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals

FLEXION = ["right_finger_1", "right_finger_2", "right_finger_3"]


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics) -> Signals:
    named = resources(dexter)
    return Signals(dexter, kinematics, [named["right_hand.opening"], named["right_hand.centre"]])


def place(signals: Signals, positions: Floats) -> dict[str, Floats]:
    """Return fingertip positions in a posture, m, by finger."""
    signals.kinematics.update(positions)
    signals.positions[:] = positions
    signals.clock[0] += 1
    return {
        name: signals.kinematics.frame(cell.link).position
        for name, cell in signals.robot.load_cells["right_hand"].items()
    }


def posture(signals: Signals, flexion: float) -> Floats:
    positions = np.zeros(len(signals.joints))
    positions[signals.joints.pick(FLEXION)] = flexion
    return positions


@pytest.mark.parametrize("flexion", [0.0, 0.6, 1.2])
def test_opening_and_centre_are_those_of_thumb_and_other_fingers(
    signals: Signals, dexter: RobotDocument, flexion: float
) -> None:
    tips = place(signals, posture(signals, flexion))
    others = (tips["finger_1"] + tips["finger_2"]) / 2
    named = resources(dexter)
    opening = signals.read(named["right_hand.opening"])
    centre = signals.read(named["right_hand.centre"])
    assert opening is not None and centre is not None
    assert opening.value == pytest.approx([np.linalg.norm(tips["finger_3"] - others)])
    assert centre.value == pytest.approx((tips["finger_3"] + others) / 2)


@pytest.mark.parametrize("flexion", [0.2, 0.7, 1.2])
def test_opening_changes_by_an_equal_part_for_each_finger(
    signals: Signals, dexter: RobotDocument, flexion: float
) -> None:
    resource, step = resources(dexter)["right_hand.opening"], 1e-5
    values = []
    for side in (-1.0, 1.0, 0.0):
        place(signals, posture(signals, flexion + side * step))
        reading = signals.read(resource)
        assert reading is not None
        values.append(float(reading.value[0]))
    assert reading.jacobian is not None
    own = reading.jacobian[0, signals.joints.pick(FLEXION)]
    assert own == pytest.approx(own[0]) and np.count_nonzero(reading.jacobian) == 3
    assert own.sum() == pytest.approx((values[1] - values[0]) / (2 * step), rel=1e-4)
