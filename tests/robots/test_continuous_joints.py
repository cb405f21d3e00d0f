"""Joints without limits take the short way to a reference, unless their turns count."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.robots.small_robot import Hinge, SmallRobot, chain, write_robot

ENDLESS = Hinge("continuous", '<limit effort="50" velocity="3"/>')
MOVE = "move: {{potential: spring, reference: arm.{}, feedback: arm, effector: arm}}"
ENGINES = ["kinematic", "mujoco", "bullet"]


def robot(folder: Path, count: str = "") -> SmallRobot:
    far = "postures: {ready: [0.3, 0.4, 0.2], far: [6.6, -6.2, 0.5]}"
    effector = f"effectors:\n  arm: {{joints: [j1, j2, j3], {far}, start: ready{count}}}"
    return write_robot(folder, chain(ENDLESS, ENDLESS, Hinge()), effector)


@pytest.mark.parametrize("engine", ENGINES)
def test_spring_to_a_posture_beyond_half_a_turn_takes_the_short_way(
    engine: str, tmp_path: Path
) -> None:
    small = robot(tmp_path)
    with small.backend(engine) as backend:
        small.run(backend, MOVE.format("far"))
        reached = backend.observe().positions
    assert reached == pytest.approx([6.6 - 2 * np.pi, -6.2 + 2 * np.pi, 0.5], abs=0.05)


def test_spring_of_an_effector_that_counts_turns_keeps_them(tmp_path: Path) -> None:
    small = robot(tmp_path, ", count_turns: true")
    with small.backend("kinematic") as backend:
        small.run(backend, MOVE.format("far"))
        reached = backend.observe().positions
    assert reached == pytest.approx([6.6, -6.2, 0.5], abs=0.05)


@pytest.mark.parametrize("engine", ENGINES)
def test_uniform_of_joints_without_limits_is_reached(engine: str, tmp_path: Path) -> None:
    small = robot(tmp_path)
    with small.backend(engine) as backend:
        assert small.run(backend, MOVE.format("uniform")).predicates[-1] == "1"
        reached = backend.observe().positions
    assert np.isfinite(reached).all()
    assert np.abs(reached[:2]).max() < np.pi + 0.5
