"""Load cells that are read once per control tick read as those that sample with the physics."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.bullet.load_cells import LoadCells as SampledCells
from cbdsl.backends.kinematic.load_cells import LoadCells
from cbdsl.documents.robot import RobotDocument

CELLS = (("hand", "a"), ("hand", "b"))


def _made(robot: RobotDocument, **contact: float) -> RobotDocument:
    return robot.model_copy(update={"contact": robot.contact.model_copy(update=contact)})


@pytest.mark.parametrize("rate", [60.0, 15.0])
def test_the_filter_lags_as_much(dexter: RobotDocument, rate: float) -> None:
    robot = _made(dexter, noise=0.0)
    wrenches = np.arange(12.0).reshape(2, 6)
    fingertips: Any = SimpleNamespace(cells=CELLS, wrenches=lambda: wrenches)
    rng = np.random.default_rng(0)
    sampled = SampledCells(fingertips, robot.contact, 1 / robot.simulation.physics_rate, rng)
    cells = LoadCells(CELLS, robot, 1 / rate, rng)
    for _ in range(4):
        cells.sample(wrenches)
        for _ in range(round(robot.simulation.physics_rate / rate)):
            sampled.sample()
        for cell in CELLS:
            assert cells.read()[cell] == pytest.approx(sampled.read()[cell])


@pytest.mark.parametrize("time_constant", [0.0, 0.02, 0.1])
@pytest.mark.parametrize("rate", [60.0, 15.0])
def test_as_much_noise_passes(dexter: RobotDocument, rate: float, time_constant: float) -> None:
    robot = _made(dexter, noise=0.05, filter=time_constant)
    nothing = np.zeros((2, 6))
    fingertips: Any = SimpleNamespace(cells=CELLS, wrenches=lambda: nothing)
    rng = np.random.default_rng(1)
    sampled = SampledCells(fingertips, robot.contact, 1 / robot.simulation.physics_rate, rng)
    cells = LoadCells(CELLS, robot, 1 / rate, rng)
    readings, expected = [], []
    for _ in range(4000):
        cells.sample(nothing)
        readings.append(cells.read()["hand", "a"])
        for _ in range(round(robot.simulation.physics_rate / rate)):
            sampled.sample()
        expected.append(sampled.read()["hand", "a"])
    assert np.std(readings[100:], axis=0) == pytest.approx(np.std(expected[100:], axis=0), rel=0.15)


def test_a_reading_is_not_changed_by_the_next_sample(dexter: RobotDocument) -> None:
    cells = LoadCells(CELLS, dexter, 1 / 60, np.random.default_rng(0))
    reading = cells.read()["hand", "a"]
    before = reading.copy()
    cells.sample(np.ones((2, 6)))
    assert (reading == before).all()
