"""Every resource of every robot."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

LIBRARY = Library(ROOT)
SHAPES = {"orientation": (3, 3), "pose": (4, 4)}


def _robot(name: str) -> RobotDocument:
    return LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document


def _observe(robot: RobotDocument, time: float, positions: np.ndarray, force: float) -> Observation:
    loads = {
        (hand, cell): np.array([0.1, 0.0, -force, 0.0, 0.0, 0.0])
        for hand, cells in robot.load_cells.items()
        for cell in cells
    }
    return Observation(time, positions, np.zeros_like(positions), loads, {})


# Drawn when a controller begins, from the features seen or known then.


@pytest.mark.parametrize("name", LIBRARY.names(RobotDocument))
def test_every_resource_is_bound_read_and_refreshed(name: str) -> None:
    robot = _robot(name)
    kinematics = Kinematics(robot, ROOT / "robots" / robot.model)
    known = {key: each for key, each in resources(robot).items() if not each.is_drawn}
    signals = Signals(robot, kinematics, resources(robot).values())
    rows = {key: signals.bind(resource) for key, resource in known.items()}
    assert [signals.bind(resource) for resource in known.values()] == list(rows.values())
    selection = signals.select(rows.values())
    posture = np.full(len(signals.joints), 0.2)
    values: list[dict[str, Reading | None]] = []
    for tick, force in enumerate((0.0, 3.0, 4.0)):
        observation = _observe(robot, 0.01 * tick, posture + 0.05 * tick, force)
        signals.update(observation)
        signals.refresh(selection)
        values.append({key: signals.reading(rows[key], each.type.name)
                       for key, each in known.items()})  # fmt: skip
    for key, reading in values[-1].items():
        if reading is None:
            continue
        size = known[key].type.size
        assert reading.value.shape == SHAPES.get(known[key].type.name, (size,)), key
        assert reading.jacobian is not None
        assert reading.jacobian.shape == (size, len(signals.joints)), key
        assert np.isfinite(reading.value).all() and np.isfinite(reading.jacobian).all(), key
