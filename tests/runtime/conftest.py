"""Whole episodes in a synthetic world, and everything that was said on the way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.policies.policy import Policy
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.observation import Observation
from cbdsl.yaml_text.library import Library
from tests.runtime.synthetic import Ball, SyntheticBackend, World

TABLE_BALL = np.array([0.55, -0.2, -0.35])

#: Flexion at which the fingers make contact, rad.
GRIP = 0.9


def on_table() -> World:
    """Return a world with a ball on the table, which the fingers of a closing hand meet."""
    return World(Ball(TABLE_BALL), contact_angle=GRIP)


@dataclass
class Played:
    """Episode and the events that its listeners received."""

    result: EpisodeResult
    backend: SyntheticBackend
    transitions: list[Transition] = field(default_factory=list)
    observations: list[Observation] = field(default_factory=list)

    def at(self, depth: int) -> list[Transition]:
        return [each for each in self.transitions if each.depth == depth]


Play = Callable[..., Played]
Watch = Callable[[Tick], None]


@pytest.fixture(scope="session")
def play(dexter: RobotDocument, urdf: Path, kinematics: Kinematics) -> Play:
    """Return a function that runs an episode; ``begin``, ``direct`` are the synthetic backend's."""

    def run(
        program: CheckedProgram,
        begin: Callable[[np.random.Generator], World] | None = None,
        direct: Callable[[World, float], None] = lambda world, time: None,
        *,
        joints: Mapping[str, float] | None = None,
        seed: int = 0,
        policy: Policy | None = None,
        watch: Watch = lambda tick: None,
        on_end: Callable[[EpisodeResult], object] | None = None,
    ) -> Played:
        backend = SyntheticBackend(dexter, urdf, begin or (lambda rng: on_table()), direct)
        runner = Runner(dexter, kinematics, program, backend, policy)
        transitions: list[Transition] = []
        observations: list[Observation] = []

        def note(tick: Tick) -> None:
            observations.append(tick.observation)
            watch(tick)

        result = runner.run(
            made_stage(joints or {}),
            seed,
            observer=EpisodeListeners(
                on_transition=transitions.append, on_tick=note, on_end=on_end
            ),
        )
        return Played(result, backend, transitions, observations)

    return run


def made_stage(joints: Mapping[str, float]) -> StageDocument:
    """Return a stage on which the head sees the table, unless ``joints`` turn it elsewhere."""
    start = {"pan": -0.4, "tilt": 1.0, **joints}
    document: dict[str, Any] = {"cbdsl": 1, "kind": "stage", "name": "made", "robot": "dexter"}
    context = {"joints": {joint: [angle, angle] for joint, angle in start.items()}}
    return StageDocument.model_validate({**document, "contexts": {"only": context}})


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., CheckedProgram]:
    """Return a function that checks programs from the texts of their sections."""

    def write(body: str, name: str = "own") -> CheckedProgram:
        path = tmp_path / "programs" / f"{name}.yaml"
        path.parent.mkdir(exist_ok=True)
        head = f"cbdsl: 1\nkind: program\nname: {name}\nrobot: dexter\n"
        path.write_text(head + body, encoding="utf-8")
        return check_program(path, {}, Library(tmp_path))

    return write
