"""Rolling and spinning friction: rolling bodies come to rest, spinning bodies slow down."""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet as p

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from tests.backends.conftest import URDF, Simulated, made_stage, run, sightless


def with_ball(motion: dict[str, Any] | None = None, **friction: float) -> StageDocument:
    """Return a stage with a ball on a table."""
    table = {"form": {"shape": "box", "size": [1.0, 1.2, 0.04]}, "position": [0.8, 0, -0.44]}
    place = {"on": "table", "x": 0.4, "y": 0.0}
    ball = {"form": {"shape": "ball", "radius": 0.05}, "mass": 0.2, **friction}
    moved = {} if motion is None else {"motion": motion}
    return made_stage(
        {"things": ["ball"], "place": place, **moved},
        fixtures={"table": {**table, **friction}},
        things={"ball": ball},
    )


def test_ball_rolls_less_far_with_rolling_friction(unseeing: Simulated) -> None:
    thrown = {"speed": 0.3, "direction": 0.0, "thrown": True}
    ways = []
    for friction in (0.0005, 0.03):
        stage = with_ball(thrown, rolling_friction=friction)
        unseeing.reset(stage, None, np.random.default_rng(0))
        start = unseeing.truth.pose("ball").position[0]
        run(unseeing, 1.0)
        ways.append(unseeing.truth.pose("ball").position[0] - start)
    assert ways[0] > 0.15
    assert ways[1] < 0.7 * ways[0]


def test_ball_that_spins_slows_down_with_spinning_friction(dexter: RobotDocument) -> None:
    backend, rates = BulletBackend(sightless(dexter), URDF), []
    for friction in (0.0, 0.03):
        stage = with_ball(spinning_friction=friction, rolling_friction=0.0)
        backend.reset(stage, None, np.random.default_rng(0))
        body, client = backend.truth.bodies["ball"], backend.truth.client
        p.resetBaseVelocity(body, [0, 0, 0], [0, 0, 20.0], physicsClientId=client)
        run(backend, 0.3)
        rates.append(p.getBaseVelocity(body, physicsClientId=client)[1][2])
    backend.close()
    assert rates[0] > 15.0
    assert rates[1] < 0.7 * rates[0]
