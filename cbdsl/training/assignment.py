"""An assignment: one trial to carry out, wherever that may be."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cbdsl.backends.backend import Backend, find_backend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.accommodate import Constants
from cbdsl.program.checked import CheckedProgram
from cbdsl.robot.kinematics import Kinematics
from cbdsl.training.classroom import BackendClassroom
from cbdsl.training.course import Nobody, Watcher, follow, open_journal
from cbdsl.training.provenance import Setting, provenance_of
from cbdsl.training.trial import Trial


@dataclass(frozen=True)
class Assignment:
    """All that a trial needs; it can be sent to another process.

    Attributes:
        program: what is learned, with the actions and limits of the trial.
        program_sha256: of its text; see ``program_digest``.
        robot: what runs it.
        urdf: the robot's model, at the same place for everybody.
        stage: the training context.
        backend: name of what embodies the robot.
        constants: of the algorithm.
        seed: of all chance.
        number: which of several trials with this seed.
        episodes: how many.
        command: what learns it again.
        path: the policy's file, at the same place for everybody.
    """

    program: CheckedProgram
    program_sha256: str
    robot: RobotDocument
    urdf: Path
    stage: StageDocument
    backend: str
    constants: Constants
    seed: int
    number: int
    episodes: int
    command: str
    path: Path

    def carry_out(
        self, body: Backend, kinematics: Kinematics, watcher: Watcher | None = None
    ) -> list[Path]:
        """Run what is left of the trial on a body, and write down what was learned.

        Returns:
            The files that were written.

        Raises:
            JournalError, BackendError, SensorError, OSError: see ``follow``.
        """
        trial = Trial(self.program, self.constants, self.seed, self.number)
        sha256, renderer = self.program_sha256, body.renderer
        setting = Setting(sha256, self.robot, self.stage, self.backend, renderer)
        provenance = provenance_of(trial, setting, self.episodes, self.command)
        classroom = BackendClassroom(self.robot, kinematics, body, self.stage)
        with open_journal(self.path, provenance) as journal:
            return follow(trial, classroom, journal, provenance, self.path, watcher or Nobody())


def carry_out_alone(assignment: Assignment) -> list[Path]:
    """Carry out a trial on a body of its own; see ``Assignment.carry_out``."""
    body = find_backend(assignment.backend)(assignment.robot, assignment.urdf)
    try:
        return assignment.carry_out(body, Kinematics(assignment.robot, assignment.urdf))
    finally:
        body.close()
