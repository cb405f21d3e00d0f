"""Simulated robot, set up for the episodes of an experiment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cbdsl.api.shipped import shipped_file, shipped_robot
from cbdsl.backends.simulated_backend import SimulatedBackend, simulate
from cbdsl.checking.program import check_program
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.episode import Runner
from cbdsl.types.policy import Policy
from cbdsl.yaml_text.library import Library, shipped

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
        name: Name of the program.
        values: Values of its parameters.
        stage: Name of a stage that replaces the program's own.
        engine: Name of the backend.
        cameras: Kind of its cameras; ``None`` for the backend's default.

    Raises:
        BackendError: The simulator cannot embody the robot.
        ImportError: The simulator is not installed.
    """
    # The shipped documents, instead of documents of the same names in the working folder.
    library = Library(shipped())
    program = check_program(shipped_file(library, ProgramDocument, name), values or {}, library)
    robot, urdf = shipped_robot(program.robot, library)
    stage_file = shipped_file(library, StageDocument, stage or program.stage or "")
    backend = simulate(engine, robot, urdf, cameras=cameras)
    try:
        yield SimulationFixture(
            robot=robot,
            urdf=urdf,
            program=program,
            stage=library.read(stage_file, StageDocument).document,
            kinematics=Kinematics(robot, urdf),
            backend=backend,
        )
    finally:
        backend.close()
