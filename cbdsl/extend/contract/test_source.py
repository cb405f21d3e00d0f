"""Contract of kinds of sensors: types, readings and Jacobians of their signals."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.api.shipped import shipped_robot
from cbdsl.documents.robot import RobotDocument, Sensor
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.robot.source_kind import SOURCES
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading

SHAPES = {"orientation": (3, 3), "pose": (4, 4)}


def _observe(robot: RobotDocument, tick: int, positions: np.ndarray, force: float) -> Observation:
    loads = {
        (hand, cell): np.array([0.1, 0.0, -force, 0.0, 0.0, 0.0])
        for hand, cells in robot.load_cells.items()
        for cell in cells
    }
    return Observation(0.01 * tick, positions, np.zeros_like(positions), loads, {})


@pytest.mark.parametrize("name", SOURCES.usable_names())
def test_sensor_in_contact_is_read_in_its_types_and_refreshed(name: str) -> None:
    shipped, urdf = shipped_robot("dexter")
    sensor = Sensor(kind=name, link="right_palm", hand="right_hand")
    robot = shipped.model_copy(update={"sensors": {"added": sensor}})
    known = {key: each for key, each in resources(robot).items() if key.startswith("added.")}
    signals = Signals(robot, Kinematics(robot, urdf), resources(robot).values())
    rows = {key: signals.bind(resource) for key, resource in known.items()}
    selection, joints = signals.select(rows.values()), len(signals.joints)
    readings: list[dict[str, Reading | None]] = []
    for tick, force in enumerate((0.0, 3.0, 4.0)):
        signals.update(_observe(robot, tick, np.full(joints, 0.2 + 0.05 * tick), force))
        signals.refresh(selection)
        readings.append({key: signals.reading(rows[key], known[key].type.name) for key in known})
    assert any(readings[-1].values()), "all signals are undefined in contact"
    for key, resource in known.items():
        before, now = readings[-2][key], readings[-1][key]
        if before is None or now is None:  # without images
            continue
        assert not np.array_equal(before.value, now.value), f"{key} is not refreshed"
        size = resource.type.size
        assert now.value.shape == SHAPES.get(resource.type.name, (size,)), key
        assert now.jacobian is not None and now.jacobian.shape == (size, joints), key
        assert np.isfinite(now.value).all() and np.isfinite(now.jacobian).all(), key
