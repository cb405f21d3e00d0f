"""A thing before a window of its own colour is not noticed, and anywhere else it is."""

from __future__ import annotations

import numpy as np
import pytest

import cbdsl
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.vision.regions.camera import heading

SEEDS = (5640000, 5640001)


def noticed(lab: cbdsl.SimulatedRobot, seed: int, context: str) -> bool:
    """Return True if something was tracked."""
    return lab.robot.run(seed, context=context).rewarded


def off_the_ball(lab: cbdsl.SimulatedRobot, seed: int) -> float:
    """Return the final error of the left camera, deg; 180 if it notices nothing."""
    last: list[Tick] = []

    def note(tick: Tick) -> None:
        last[:] = [tick]

    if not lab.robot.run(seed, context="elsewhere", on_tick=note).rewarded:
        return 180.0
    frame = last[0].signals.kinematics.frame("left_camera")
    ball = lab.truth.position("ball")
    angles = heading(frame.rotation.T @ (ball - frame.position))
    return float(np.degrees(np.abs(angles)).max())


@pytest.mark.parametrize(
    ("engine", "cameras"),
    [("mujoco", "ideal"), pytest.param("bullet", None, marks=pytest.mark.slow)],
)
def test_notice_ignores_the_window_and_tracks_a_ball_elsewhere(
    engine: str, cameras: str | None
) -> None:
    with cbdsl.simulate("notice", backend=engine, cameras=cameras) as lab:
        for seed in SEEDS:
            assert off_the_ball(lab, seed) < 8.0
            assert not noticed(lab, seed, "before_the_window")
            assert not noticed(lab, seed, "nobody")
    program = cbdsl.load("searchtrack", stage="something_new", values={"feature": "blue"})
    with cbdsl.simulate(program, backend=engine, cameras=cameras) as lab:
        assert noticed(lab, SEEDS[0], "before_the_window"), "what is blue is there to be seen"
