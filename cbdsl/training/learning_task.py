"""Learning task: one trial, in this process or another."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cbdsl.backends.backend import Backend
from cbdsl.documents.digest import ProgramDigest
from cbdsl.documents.document import Section
from cbdsl.documents.policy import Provenance
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.episode_watcher import EpisodeWatcher
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl.training.journal import require_usable
from cbdsl.training.provenance import TrialSetting, provenance_of
from cbdsl.training.trial import Trial
from cbdsl.training.trial_loop import (
    NullObserver,
    TrialObserver,
    identity_of,
    journal_file,
    open_journal,
    require_free,
    require_writable,
    run_trial,
)


@dataclass(frozen=True)
class LearningTask:
    """One trial with everything it needs; it can be sent to another process.

    Attributes:
        program: what is learned, with the actions and limits of the trial.
        digest: of its text and of the policies that it uses.
        robot: what runs it.
        urdf: the robot's model, at the same place for everybody.
        stage: the training context.
        backend: name of what embodies the robot.
        learner: name of the algorithm.
        constants: of the algorithm.
        seed: of all chance.
        number: which of several trials with this seed.
        episodes: how many.
        command: what learns it again.
        path: the policy's file, at the same place for everybody.
        cameras: kind of the backend's cameras, its own choice when ``None``.
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

    @property
    def journal(self) -> Path:
        """File of its episodes."""
        return journal_file(self.path)

    def require_ready(self, *, resume: bool) -> None:
        """Check, before hours are spent on it, that its outcome can be written.

        Args:
            resume: whether to go on with a trial that was begun there.

        Raises:
            JournalError: something is in the way, or the trial that was begun there is another.
            OSError: nothing can be written there.
        """
        require_writable(self.path)
        require_free(self.path, (*self.robot.effectors, *self.robot.groups), resume=resume)
        if self.journal.exists():
            # What makes the images is known only to a body.
            known = identity_of(self._provenance(self._trial(), "unknown"), ("renderer",))
            require_usable(self.journal, known)

    def run(
        self,
        body: Backend,
        kinematics: Kinematics,
        observer: TrialObserver | None = None,
        watcher: EpisodeWatcher | None = None,
    ) -> list[Path]:
        """Run the remaining episodes on a body and write the knowledge.

        Args:
            body: where they are run.
            kinematics: of the robot.
            observer: of the trial's progress.
            watcher: of the episodes themselves.

        Returns:
            The files that were written.

        Raises:
            JournalError, BackendError, EpisodeError, OSError: see ``run_trial``.
        """
        trial = self._trial()
        provenance = self._provenance(trial, body.renderer)
        runner = BackendEpisodeRunner(self.robot, kinematics, body, self.stage, watcher)
        with open_journal(self.path, provenance) as journal:
            return run_trial(
                trial, runner, journal, provenance, self.path, observer or NullObserver()
            )

    def _trial(self) -> Trial:
        return Trial(self.program, self.constants, self.seed, self.number, self.learner)

    def _provenance(self, trial: Trial, renderer: str) -> Provenance:
        setting = TrialSetting(self.digest, self.robot, self.stage, self.backend, renderer)
        return provenance_of(trial, setting, self.episodes, self.command)
