"""Jobs: one trial of an experiment that learns, in any process."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cbdsl.api.control import Kinematics
from cbdsl.api.documents import RobotDocument, write_text
from cbdsl.api.trials import Backend, TaskObserver
from cbdsl_reproduction.experiment import Experiment, RunSettings
from cbdsl_reproduction.trial_runner import TrialRunner, shipped_dexter, trials

# Least time between two progress reports, s.
_PAUSE = 1.0


@dataclass(frozen=True)
class TrialJob:
    """One trial of each series of an experiment, with its held-out episodes.

    After all jobs, all episodes of the experiment are stored in the folder of its settings. A run
    of the experiment then only reads them, so that its outcome does not depend on the processes.

    Attributes:
        experiment: Experiment in which the robot learns.
        settings: Settings of the whole experiment.
        path: File to which the job writes its progress, ``<done> <total>``, in episodes.
        robot: Robot that learns.
        urdf: Path of the robot's model.
    """

    experiment: Experiment
    settings: RunSettings
    path: Path
    robot: RobotDocument
    urdf: Path

    @property
    def backend(self) -> str:
        """Name of the backend that embodies the robot."""
        return self.settings.backend

    @property
    def cameras(self) -> str | None:
        """Kind of the backend's cameras."""
        return self.settings.cameras

    def run(self, body: Backend, kinematics: Kinematics, observer: TaskObserver[Any]) -> list[Path]:
        """Run its episodes on a body; see ``Job.run``.

        Raises:
            JournalError, BackendError, EpisodeError, OSError: As ``TrialRunner``.
        """
        settings = replace(self.settings, progress=_Notice(self.path).note)
        dexter = TrialRunner(settings, body, self.robot, kinematics, observer)
        self.experiment.imported().gather(dexter, settings, self.experiment.name)
        return []

    def progress(self) -> tuple[int, int]:
        """Return the numbers of finished and of all episodes; (0, 0) at first."""
        if not self.path.exists():
            return 0, 0
        done, total = map(int, self.path.read_text(encoding="utf-8").split())
        return done, total


class _Notice:
    """Writer of the progress of a job to a file.

    Args:
        path: File to write.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._written = path, -_PAUSE

    def note(self, done: int, total: int) -> None:
        """Write that ``done`` of ``total`` parts are finished."""
        if time.monotonic() >= self._written + _PAUSE or done == total:
            self._written = time.monotonic()
            write_text(f"{done} {total}\n", self._path)


@contextmanager
def trial_jobs(experiment: Experiment, settings: RunSettings) -> Iterator[list[TrialJob]]:
    """Provide the jobs of an experiment in which the robot learns, one for each trial.

    Args:
        experiment: Experiment in which the robot learns.
        settings: Settings of the experiment; their progress callback is not used.
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
