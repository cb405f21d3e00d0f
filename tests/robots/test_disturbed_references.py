"""Speeds and limits of references on every engine, with faulty encoders and jumping targets."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.checking.program import check_program
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.program_composer import Composer
from cbdsl.sensing.observation import Observation
from cbdsl.yaml_text.library import Library
from tests.robots.small_robot import Hinge, SmallRobot, chain, write_robot

ENGINES = ["kinematic", "mujoco", "bullet"]
FASTEST, LIMIT, TICKS = np.array([0.8, 1.2, 1.4]), 2.0, 240  # rad/s, rad
PROGRAM = """
cbdsl: 1
kind: program
name: go
robot: small
controllers:
  move: {potential: spring, reference: [40 cm, 30 cm, 0 cm], feedback: arm.position,
         effector: arm.position}
  bend: {potential: spring, reference: arm.ready, feedback: arm, effector: arm}
actions: [bend ◁ move, move, bend]
policy: {XX: bend ◁ move, "0*": bend ◁ move, "1*": bend ◁ move}
"""


def robot(folder: Path) -> SmallRobot:
    hinges = [
        Hinge("revolute", f'<limit lower="-2" upper="2" effort="50" velocity="{speed}"/>')
        for speed in FASTEST
    ]
    tip = "tip: {link: l3, offset: [25 cm, 0 m, 0 m]}"
    joints = "joints: [j1, j2, j3], postures: {ready: [0.3, 0.4, 0.2]}, start: ready"
    return write_robot(folder, chain(*hinges), f"effectors:\n  arm: {{{joints}, {tip}}}")


def spiking(backend: SimulatedBackend[Any], rng: np.random.Generator) -> None:
    """Have one joint of every tenth observation read up to 3 rad off."""
    observe, count = backend.observe, 0

    def spiked() -> Observation:
        nonlocal count
        observation, count = observe(), count + 1
        if count % 10 == 0:
            positions = observation.positions.copy()
            positions[rng.integers(len(positions))] += rng.uniform(-3.0, 3.0)
            return replace(observation, positions=positions)
        return observation

    backend.observe = spiked  # type: ignore[method-assign]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("spikes", [False, True])
def test_references_keep_speeds_and_limits_if_targets_jump_and_encoders_spike(
    engine: str, spikes: bool, tmp_path: Path
) -> None:
    small, rng = robot(tmp_path), np.random.default_rng(7)
    file = tmp_path / "programs" / "go.yaml"
    file.parent.mkdir()
    file.write_text(PROGRAM, "utf-8")
    program = check_program(file, {}, Library(tmp_path))
    composer, references, times = Composer(), [], []
    with small.backend(engine) as backend:
        if spikes:
            spiking(backend, rng)
        runner = Runner(small.document, small.kinematics(), program, backend)
        with closing(runner.ticks(small.stage(), 1)) as ticks:
            for number, tick in enumerate(islice(ticks, TICKS)):
                if number == 0:
                    composer.begin(tick.run)
                if number % 15 == 0:
                    composer.hold("move", tuple(rng.uniform(-1.2, 1.2, 3)))
                references.append(tick.actuation.reference.copy())
                times.append(tick.observation.time)
    steps, period = np.abs(np.diff(references, axis=0)), float(np.diff(times).max())
    assert (steps <= FASTEST * period * (1 + 1e-6)).all()
    assert np.abs(references).max() <= LIMIT
    assert steps.max() >= 0.5 * FASTEST.min() * period
