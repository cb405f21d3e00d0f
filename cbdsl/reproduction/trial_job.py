"""Jobs: one trial of an experiment that learns, in any process."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from cbdsl.backends.backend import Backend
from cbdsl.documents.robot import RobotDocument
from cbdsl.reproduction.experiment import Experiment, RunSettings
from cbdsl.reproduction.trial_runner import TrialRunner, shipped_dexter, trials
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.trial_loop import TrialObserver
from cbdsl.yaml_text.writer import write_text

# Least time between two words about how far it is, s.
_PAUSE = 1.0


@dataclass(frozen=True)
class TrialJob:
    """One trial of each series of an experiment, with the held-out episodes that belong to it.

    Once all jobs are carried out, all episodes of the experiment are kept in the folder of its
    settings, and to run it is to read them: so its outcome does not depend on who ran them.

    Attributes:
        experiment: in which the robot learns.
        settings: of the whole experiment.
        path: where the job tells how far it is, ``<done> <total>``, in episodes.
        robot: whose trials they are.
        urdf: the robot's model.
    """

    experiment: Experiment
    settings: RunSettings
    path: Path
    robot: RobotDocument
    urdf: Path

    @property
    def backend(self) -> str:
        """Name of what embodies the robot."""
        return self.settings.backend

    @property
    def cameras(self) -> str | None:
        """Kind of the backend's cameras."""
        return self.settings.cameras

    def run(self, body: Backend, kinematics: Kinematics, observer: TrialObserver) -> list[Path]:
        """Run its episodes on a body; see ``Job.run``.

        Raises:
            JournalError, BackendError, EpisodeError, OSError: see ``TrialRunner``.
        """
        settings = replace(self.settings, progress=_Notice(self.path).note)
        dexter = TrialRunner(settings, body, self.robot, kinematics, observer)
        self.experiment.imported().gather(dexter, settings, self.experiment.name)
        return []

    def progress(self) -> tuple[int, int]:
        """Finished episodes and all; (0, 0) before it begins."""
        if not self.path.exists():
            return 0, 0
        done, total = map(int, self.path.read_text(encoding="utf-8").split())
        return done, total


class _Notice:
    """Writes the progress of a job to a file.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._written = path, -_PAUSE

    def note(self, done: int, total: int) -> None:
        """``done`` of ``total`` parts are over."""
        if time.monotonic() >= self._written + _PAUSE or done == total:
            self._written = time.monotonic()
            write_text(f"{done} {total}\n", self._path)


@contextmanager
def trial_jobs(experiment: Experiment, settings: RunSettings) -> Iterator[list[TrialJob]]:
    """The jobs of an experiment in which the robot learns, one for each trial.

    Args:
        experiment: the experiment.
        settings: of it; who watches is not told.
    """
    robot, urdf = shipped_dexter()
    folder = settings.folder.absolute()
    count = max(
        trials(settings, series) for series in experiment.imported().series_of(experiment.name)
    )
    with TemporaryDirectory(prefix="cb_reproduce_") as place:
        yield [
            TrialJob(
                experiment,
                replace(settings, folder=folder, progress=RunSettings.progress, only=number),
                Path(place) / str(number),
                robot,
                urdf.absolute(),
            )
            for number in range(count)
        ]
