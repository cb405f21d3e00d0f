"""Encoders read positions in steps."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.staging.encoders import Encoders
from cbdsl.documents.robot import RobotDocument

PERIOD = 1 / 60


def test_readings_are_whole_steps_within_half_of_one(dexter: RobotDocument) -> None:
    encoders = Encoders(dexter, PERIOD)
    steps = np.array([e.resolution for e in dexter.effectors.values() for _ in e.joints])
    positions = np.random.default_rng(0).uniform(-2, 2, len(steps))
    read, velocities = encoders.begin(positions)
    assert read / steps == pytest.approx(np.rint(read / steps))
    assert (np.abs(read - positions) <= steps / 2 + 1e-12).all()
    assert (read != positions).all()
    assert not velocities.any()


def test_velocities_are_differences_of_readings(dexter: RobotDocument) -> None:
    encoders = Encoders(dexter, PERIOD)
    start = np.zeros(len(encoders.begin(np.zeros(24))[0]))
    first, _ = encoders.begin(start)
    second, velocities = encoders.read(start + 0.0123)
    assert velocities == pytest.approx((second - first) / PERIOD)
    _, at_rest = encoders.read(start + 0.0123)
    assert not at_rest.any()


def test_without_steps_positions_are_exact(dexter: RobotDocument) -> None:
    effectors = {
        name: each.model_copy(update={"resolution": 0.0}) for name, each in dexter.effectors.items()
    }
    encoders = Encoders(dexter.model_copy(update={"effectors": effectors}), PERIOD)
    positions = np.random.default_rng(0).uniform(-2, 2, 24)
    assert (encoders.begin(positions)[0] == positions).all()
