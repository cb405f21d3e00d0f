"""A simulated robot, set up for the episodes of an experiment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cbdsl.backends.simulated_backend import SimulatedBackend, simulate
from cbdsl.checking.program import check_program
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.reproduction.shipped import shipped_file, shipped_robot
from cbdsl.runtime.episode import Runner
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.types.policy import Policy
from cbdsl.yaml_text.library import Library, shipped

#: The backend on which the experiments of the source are measured.
REFERENCE = "bullet"


@dataclass(frozen=True)
class SimulationFixture:
    """The parts of a simulated robot that an experiment works with.

    Attributes:
        robot: the robot document.
        program: the checked program.
        stage: the program's own stage.
        kinematics: of the robot; for the experiment alone, episodes have their own.
        backend: the simulated body; its ``truth`` is for judging, never for the robot.
    """

    robot: RobotDocument
    urdf: Path
    program: CheckedProgram
    stage: StageDocument
    kinematics: Kinematics
    backend: SimulatedBackend[Any]

    def runner(self, policy: Policy | None = None) -> Runner:
        """Runs episodes of the program, under its own policy or another."""
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
        name: the program.
        values: of its parameters.
        stage: another stage than the program's own.
        engine: name of the backend.
        cameras: kind of its cameras; without it, the backend's own choice.

    Raises:
        BackendError: the simulator cannot embody the robot.
        ImportError: the simulator is not installed.
    """
    # What is shipped, not what somebody may have put into the working folder under its name.
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
