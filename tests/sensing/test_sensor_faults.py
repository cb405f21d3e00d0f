"""Numbers that nothing can be computed with are refused, with the sensor that gave them."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.sensor_faults import SensorError, require_finite


def check(dexter: RobotDocument, kinematics: Kinematics, **wrong: tuple[int, float]) -> None:
    """Check sensors at rest but for one number of some of them."""
    joints = kinematics.joints.names
    measured = {name: np.zeros(len(joints)) for name in ("positions", "velocities")}
    cells = [(hand, cell) for hand, own in dexter.load_cells.items() for cell in own]
    wrenches = np.zeros((len(cells), 6))
    for name, (place, value) in wrong.items():
        (wrenches[1] if name == "load" else measured[name])[place] = value
    loads = dict(zip(cells, wrenches, strict=True))
    require_finite(Observation(0.0, loads=loads, images={}, **measured), wrenches, dexter, joints)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200])
def test_sensor_is_named(dexter: RobotDocument, kinematics: Kinematics, value: float) -> None:
    joint = kinematics.joints.names[3]
    owner = next(name for name, each in dexter.effectors.items() if joint in each.joints)
    for what in ("position", "velocity"):
        plural = {"position": "positions", "velocity": "velocities"}[what]
        with pytest.raises(SensorError, match=f"the {what} of joint {joint} of {owner} is not"):
            check(dexter, kinematics, **{plural: (3, value)})
    hand = next(iter(dexter.load_cells))
    finger = list(dexter.load_cells[hand])[1]
    with pytest.raises(SensorError, match=rf"the load cell {hand}\.{finger} is not finite"):
        check(dexter, kinematics, load=(5, value))


def test_jointly_overflowing_readings_are_refused(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    check(dexter, kinematics, positions=(0, 1e150), velocities=(0, -1e150), load=(0, 1e150))
    with pytest.raises(SensorError, match="too large to compute with"):
        check(dexter, kinematics, positions=(0, 1.2e154), velocities=(1, 1.2e154))
    with pytest.raises(SensorError, match="too large to compute with"):
        check(dexter, kinematics, positions=(0, 1.2e154), load=(2, -1.2e154))
