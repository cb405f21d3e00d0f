"""Simulated robot, set up for the episodes of an experiment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cbdsl.api.control import Kinematics
from cbdsl.api.documents import RobotDocument, StageDocument
from cbdsl.api.program import CheckedProgram, Policy
from cbdsl.api.sensing import Runner
from cbdsl.api.shipped import shipped_program
from cbdsl.api.trials import SimulatedBackend, embody_simulated

#: Backend on which the experiments of the source are measured.
REFERENCE = "bullet"


@dataclass(frozen=True)
class SimulationFixture:
    """Parts of a simulated robot for an experiment.

    Attributes:
        robot: Robot document.
        program: Checked program.
        stage: Stage of the episodes.
        kinematics: Kinematics of the robot for the experiment alone; episodes have their own.
        backend: Simulated body; its ``truth`` is for judging, never for the robot.
    """

    robot: RobotDocument
    urdf: Path
    program: CheckedProgram
    stage: StageDocument
    kinematics: Kinematics
    backend: SimulatedBackend[Any]

    def runner(self, policy: Policy | None = None) -> Runner:
        """Return a runner of episodes of the program, under its own policy or another."""
        kinematics = Kinematics(self.robot, self.urdf)
        return Runner(self.robot, kinematics, self.program, self.backend, policy)


@contextmanager
def simulation_fixture(
    name: str,
    values: Mapping[str, str] | None = None,
    stage: str | None = None,
    engine: str = REFERENCE,
    cameras: str | None = None,
) -> Iterator[SimulationFixture]:
    """Set up a shipped program and its robot on the simulator.

    Args:
        name: Name of the shipped program, or file of another.
        values: Values of its parameters.
        stage: Name of a stage that replaces the program's own.
        engine: Name of the backend.
        cameras: Kind of its cameras; ``None`` for the backend's default.

    Raises:
        BackendError: The simulator cannot embody the robot.
        ImportError: The simulator is not installed.
    """
    request = shipped_program(name, stage=stage, values=values)
    robot, urdf = request.robot, request.urdf
    backend = embody_simulated(engine, robot, urdf, cameras=cameras)
    try:
        yield SimulationFixture(
            robot=robot,
            urdf=urdf,
            program=request.program,
            stage=request.stage,
            kinematics=Kinematics(robot, urdf),
            backend=backend,
        )
    finally:
        backend.close()
