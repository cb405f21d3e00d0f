"""Contract of kinds of sensors: types, readings and Jacobians of their signals."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.api.shipped import shipped_robot
from cbdsl.documents.robot import RobotDocument, Sensor
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.robot.source_kind import SOURCES
from cbdsl.sensing.channels import Moments, Region
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading

COLOURS = tuple(enumerate(("red", "yellow", "green", "blue")))
SHAPES = {"orientation": (3, 3), "pose": (4, 4)}


def _observe(robot: RobotDocument, tick: int, positions: np.ndarray, force: float) -> Observation:
    loads = {
        (hand, cell): np.array([0.1, 0.0, -force, 0.0, 0.0, 0.0])
        for hand, cells in robot.load_cells.items()
        for cell in cells
    }
    spot = Region(100, 90.0, 60.0, False, Moments(8.0, 0.0, 8.0))
    seen = {
        camera: {c: (spot._replace(column=90.0 + 30.0 * k - 8.0 * n),) for k, c in COLOURS}
        for n, camera in enumerate(robot.main_cameras)
    }
    return Observation(0.01 * tick, positions, np.zeros_like(positions), loads, {}, seen)


@pytest.mark.parametrize("name", SOURCES.usable_names())
def test_sensor_in_contact_is_read_in_its_types_and_refreshed(name: str) -> None:
    shipped, urdf = shipped_robot("dexter")
    sensor = Sensor(kind=name, link="right_palm", hand="right_hand")
    robot = shipped.model_copy(update={"sensors": {"added": sensor}})
    known = {key: each for key, each in resources(robot).items() if key.startswith("added.")}
    assert known
    signals = Signals(robot, Kinematics(robot, urdf), resources(robot).values())
    rows = {key: signals.bind(resource) for key, resource in known.items()}
    selection, joints = signals.select(rows.values()), len(signals.joints)
    readings: list[dict[str, Reading | None]] = []
    for tick, force in enumerate((0.0, 3.0, 4.0)):
        signals.update(_observe(robot, tick, np.full(joints, 0.2 + 0.05 * tick), force))
        signals.refresh(selection)
        readings.append({key: signals.reading(rows[key], known[key].type.name) for key in known})
    for key, resource in known.items():
        before, now = readings[-2][key], readings[-1][key]
        assert before is not None and now is not None, f"{key} is undefined in contact"
        assert not np.array_equal(before.value, now.value), f"{key} is not refreshed"
        size = resource.type.size
        assert now.value.shape == SHAPES.get(resource.type.name, (size,)), key
        assert now.jacobian is not None and now.jacobian.shape == (size, joints), key
        assert np.isfinite(now.value).all() and np.isfinite(now.jacobian).all(), key
