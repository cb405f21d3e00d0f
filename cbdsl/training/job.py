"""Jobs such as trials, and the body that those of one process share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from cbdsl.backends.backend import Backend, embody
from cbdsl.documents.digest import digest
from cbdsl.documents.robot import RobotDocument
from cbdsl.errors.errors import UsageError
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.trial_loop import TrialObserver

Workplace = tuple[Backend, Kinematics]

# Building a body takes as long as some episodes. A process has one thread and one robot.
_kept: dict[tuple[str, str | None, str, Path], Workplace] = {}


class Job(Protocol):
    """Work for a process of its own; it can be sent to another process.

    Attributes:
        path: a file in a folder that all who work see.
        robot: whose body it needs.
        urdf: the robot's model, at the same place for everybody.
        backend: name of what embodies the robot.
        cameras: kind of its cameras, its own choice when ``None``.
    """

    @property
    def path(self) -> Path: ...
    @property
    def robot(self) -> RobotDocument: ...
    @property
    def urdf(self) -> Path: ...
    @property
    def backend(self) -> str: ...
    @property
    def cameras(self) -> str | None: ...

    def run(self, body: Backend, kinematics: Kinematics, observer: TrialObserver) -> list[Path]:
        """Run it on a body; the observer is told of each finished episode.

        Returns:
            The files that were written.
        """
        ...


class AbandonedError(UsageError):
    """A trial was cancelled."""


def run_job(job: Job, observer: TrialObserver) -> list[Path]:
    """Run a job in this process.

    Args:
        job: Job, such as a trial.
        observer: Observer that may end the job by an exception.

    Returns:
        The files that were written.

    Raises:
        JournalError, BackendError, EpisodeError, OSError: see ``run_trial``.
    """
    with _workplace(job) as (body, kinematics):
        return job.run(body, kinematics, observer)


@contextmanager
def _workplace(job: Job) -> Iterator[Workplace]:
    """Body for a job, built for the first one of its kind and kept."""
    key = (job.backend, job.cameras, digest(job.robot), job.urdf)
    if key not in _kept:
        body = embody(job.backend, job.robot, job.urdf, cameras=job.cameras)
        _kept[key] = body, Kinematics(job.robot, job.urdf)
    try:
        yield _kept[key]
    except BaseException:
        # Its state is unknown.
        _kept.pop(key)[0].close()
        raise
