"""Jobs, such as trials, and the body that the jobs of one process share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from cbdsl.backends.backend import Backend, embody
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.digest import digest
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.training.trial_loop import TrialObserver

Workplace = tuple[Backend, Kinematics]

# Building a body takes as long as some episodes. A process has one thread and one robot.
_kept: dict[tuple[str, str | None, str, Path], Workplace] = {}


class Job(Protocol):
    """Work for a separate process; it can be sent to another process.

    Attributes:
        path: Path of a file in a folder that all workers see.
        robot: Robot whose body the job needs.
        urdf: Path of the robot's URDF model, the same for all workers.
        backend: Name of the backend.
        cameras: Kind of its cameras; ``None`` for the backend's default.
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
        """Run the job on a body; the observer receives each finished episode.

        Returns:
            Written files.
        """
        ...


class AbandonedError(UsageError):
    """Error of a cancelled trial."""


def run_job(job: Job, observer: TrialObserver) -> list[Path]:
    """Run a job in this process.

    Args:
        job: Job, such as a trial.
        observer: Observer that may end the job by an exception.

    Returns:
        Written files.

    Raises:
        JournalError, BackendError, EpisodeError, OSError: Errors of ``run_trial``.
    """
    with _workplace(job) as (body, kinematics):
        return job.run(body, kinematics, observer)


@contextmanager
def _workplace(job: Job) -> Iterator[Workplace]:
    """Yield the body for a job, built for the first one of its kind and kept."""
    key = (job.backend, job.cameras, digest(job.robot), job.urdf)
    if key not in _kept:
        body = embody(job.backend, job.robot, job.urdf, cameras=job.cameras)
        _kept[key] = body, Kinematics(job.robot, job.urdf)
    try:
        yield _kept[key]
    except BaseException:
        # The state of the body is unknown after an exception.
        _kept.pop(key)[0].close()
        raise
