"""Bullet's own features: worlds that start empty, servos that lag, physics steps."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.observation import Observation
from tests.backends.conftest import URDF, made_stage, stage_named


def test_reset_removes_all_objects_of_the_last_episode(backend: BulletBackend) -> None:
    rng = np.random.default_rng(0)
    for _ in range(3):
        backend.reset(stage_named("table_right"), None, rng)
        assert len(backend.truth.names()) == 2
    backend.reset(stage_named("absent"), None, rng)
    assert backend.truth.names() == ("table",)
    assert not _reddish(backend.observe()).any()


def _reddish(observation: Observation) -> np.ndarray:
    pixels = np.stack(list(observation.images.values())).astype(int)
    return (pixels[..., 0] > 60) & (pixels[..., 1] < 10)


def test_joints_follow_their_references(blind: BulletBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    start = blind.observe().positions
    goal = start + np.where(start > 0, -0.2, 0.2)
    steps = round(0.5 / blind.control_period)
    for share in np.linspace(0, 1, steps):
        blind.apply(start + share * (goal - start))
        blind.step()
    for _ in range(steps):
        blind.step()
    assert blind.observe().positions == pytest.approx(goal, abs=0.01)
    assert blind.observe().time == pytest.approx(2 * steps * blind.control_period)


def test_physics_rate_must_be_a_multiple_of_the_control_rate(dexter: RobotDocument) -> None:
    simulation = dexter.simulation.model_copy(update={"physics_rate": 200.0})
    robot = dexter.model_copy(update={"simulation": simulation})
    with pytest.raises(BackendError, match=rf"200 Hz.*multiple.*{dexter.control.rate:g} Hz"):
        BulletBackend(robot, URDF)
