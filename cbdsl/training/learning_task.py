"""Learning task: one trial, in this process or another."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cbdsl.backends.backend import Backend
from cbdsl.documents.document import Section
from cbdsl.documents.document_digest import ProgramDigest
from cbdsl.documents.policy import Identity, Provenance
from cbdsl.documents.relations import RelationsDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.storage.journal import require_usable
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl.training.provenance import TrialSetting, provenance_of
from cbdsl.training.task_files import trial_journal
from cbdsl.training.task_observer import TaskObserver
from cbdsl.training.trial import Trial
from cbdsl.training.trial_work import identity_of, open_journal, require_ready, run_trial


@dataclass(frozen=True)
class LearningTask:
    """Trial with all its inputs; it can be sent to another process.

    Attributes:
        program: Program to learn, with the actions and limits of the trial.
        digest: Digest of its text and of the policies that it uses.
        robot: Robot that runs the program.
        urdf: Path of the robot's URDF model, the same for all workers.
        stage: Training context.
        backend: Name of the backend.
        learner: Name of the algorithm.
        constants: Constants of the algorithm.
        seed: Seed of all random numbers.
        number: Number of this trial among several with this seed.
        episodes: Number of episodes.
        command: Command that repeats the trial.
        path: Path of the policy, the same for all workers.
        cameras: Kind of the backend's cameras; ``None`` for the backend's default.
        earlier: Knowledge from which the learner goes on, if any.
        origin: Robot that learned the policy, if another one did.
    """

    program: CheckedProgram
    digest: ProgramDigest
    robot: RobotDocument
    urdf: Path
    stage: StageDocument
    backend: str
    learner: str
    constants: Section
    seed: int
    number: int
    episodes: int
    command: str
    path: Path
    cameras: str | None = None
    earlier: RelationsDocument | None = None
    origin: Identity | None = None

    @property
    def journal(self) -> Path:
        """File of its episodes."""
        return trial_journal(self.path)

    def require_ready(self, *, resume: bool) -> None:
        """Check that the outcome can be written, before hours are spent on the trial.

        Args:
            resume: True to continue a trial that was begun there.

        Raises:
            JournalError: If other files are in the way, or another trial was begun there.
            OSError: If the files cannot be written.
        """
        effectors = (*self.robot.effectors, *self.robot.groups)
        require_ready(self.path, effectors, resume=resume)
        if self.journal.exists():
            # Only a body knows its renderer.
            known = identity_of(self._provenance(self._trial(), "unknown"), ("renderer",))
            require_usable(self.journal, known)

    def run(
        self,
        body: Backend,
        kinematics: Kinematics,
        observer: TaskObserver[Experience] | None = None,
        watcher: EpisodeObserver | None = None,
    ) -> list[Path]:
        """Run the remaining episodes on a body and write the knowledge.

        Args:
            body: Backend that runs them.
            kinematics: Kinematics of the robot.
            observer: Observer of the trial's progress.
            watcher: Observer of the episodes.

        Returns:
            Written files.

        Raises:
            JournalError, BackendError, EpisodeError, OSError: Errors of ``run_trial``.
        """
        trial = self._trial()
        provenance = self._provenance(trial, body.renderer)
        runner = BackendEpisodeRunner(self.robot, kinematics, body, self.stage, watcher)
        with open_journal(self.path, provenance) as journal:
            return run_trial(
                trial, runner, journal, provenance, self.path, observer or TaskObserver()
            )

    def _trial(self) -> Trial:
        return Trial(
            self.program, self.constants, self.seed, self.number, self.learner, self.earlier
        )

    def _provenance(self, trial: Trial, renderer: str) -> Provenance:
        setting = TrialSetting(
            self.digest, self.robot, self.stage, self.backend, renderer, self.origin
        )
        return provenance_of(trial, setting, self.episodes, self.command)
