"""Shares: an experiment that learns, one trial at a time, wherever that may be."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from cbdsl.backends.backend import Backend
from cbdsl.documents.robot import RobotDocument
from cbdsl.reproduction.experiment import Experiment, Settings
from cbdsl.reproduction.school import School, shipped_dexter, trials
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.course import Watcher
from cbdsl.yaml_text.writer import write_text

# Least time between two words about how far it is, s.
_PAUSE = 1.0


@dataclass(frozen=True)
class Share:
    """One trial of each lesson of an experiment, with the held-out episodes that belong to it.

    Once all shares are carried out, all episodes of the experiment are kept in the folder of its
    settings, and to run it is to read them: so its outcome does not depend on who ran them.

    Attributes:
        experiment: in which the robot learns.
        settings: of the whole experiment.
        path: where the share tells how far it is, ``<done> <total>``, in episodes.
        robot: whose trials they are.
        urdf: the robot's model.
    """

    experiment: Experiment
    settings: Settings
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

    def carry_out(self, body: Backend, kinematics: Kinematics, watcher: Watcher) -> list[Path]:
        """Run its episodes on a body; see ``Job.carry_out``.

        Raises:
            JournalError, BackendError, EpisodeError, OSError: see ``School``.
        """
        settings = replace(self.settings, progress=_Notice(self.path).note)
        dexter = School(settings, body, self.robot, kinematics, watcher)
        self.experiment.imported().gather(dexter, settings, self.experiment.name)
        return []

    def told(self) -> tuple[int, int]:
        """How many of how many episodes are over; none of none before it begins."""
        if not self.path.exists():
            return 0, 0
        done, total = map(int, self.path.read_text(encoding="utf-8").split())
        return done, total


class _Notice:
    """Tells others how far something is, in a file.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._told = path, -_PAUSE

    def note(self, done: int, total: int) -> None:
        """``done`` of ``total`` parts are over."""
        if time.monotonic() >= self._told + _PAUSE or done == total:
            self._told = time.monotonic()
            write_text(f"{done} {total}\n", self._path)


@contextmanager
def shared_out(experiment: Experiment, settings: Settings) -> Iterator[list[Share]]:
    """The shares of an experiment in which the robot learns, one for each trial.

    Args:
        experiment: the experiment.
        settings: of it; who watches is not told.
    """
    robot, urdf = shipped_dexter()
    folder = settings.folder.absolute()
    count = max(
        trials(settings, lesson) for lesson in experiment.imported().lessons(experiment.name)
    )
    with TemporaryDirectory(dir=folder, prefix=".cb_reproduce_") as place:
        yield [
            Share(
                experiment,
                replace(settings, folder=folder, progress=Settings.progress, only=number),
                Path(place) / str(number),
                robot,
                urdf.absolute(),
            )
            for number in range(count)
        ]
