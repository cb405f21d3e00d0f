"""Worker of a cluster: runs one job after another, all on one body."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from distributed import Worker, get_worker
from distributed.core import Status

from cbdsl.backends.backend import Backend, embody
from cbdsl.documents.digest import digest
from cbdsl.documents.robot import RobotDocument
from cbdsl.errors.errors import UsageError
from cbdsl.learning.experience import Experience
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.provenance import versions
from cbdsl.training.trial_loop import TrialObserver

Workplace = tuple[Backend, Kinematics]

# Building a body takes as long as some episodes. A process has one thread and one robot.
_kept: dict[tuple[str, str | None, str, Path], Workplace] = {}


class Job(Protocol):
    """Work for a cluster; it can be sent to another process.

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


def dask_setup(_: Worker) -> None:
    """Leave Ctrl-C to the command that started this process; Dask calls this at its start."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def work(job: Job, there: Path, expected: Mapping[str, str]) -> list[Path]:
    """Run a job in this process.

    Args:
        job: such as a trial.
        there: a file that whoever asks for it sees.
        expected: versions of what the outcome depends on.

    Returns:
        The files that were written.

    Raises:
        UsageError: this worker would learn something else, or put it elsewhere.
        JournalError, BackendError, EpisodeError, OSError: see ``run_trial``.
    """
    _require_fit(there, expected)
    with _workplace(job) as (body, kinematics):
        return job.run(body, kinematics, CancellationCheck())


class CancellationCheck:
    """Observer that ends a cancelled trial, so that another worker can go on with it."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """See ``TrialObserver.begin``."""

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """See ``TrialObserver.note``."""
        worker = get_worker()
        task = worker.state.tasks.get(worker.get_current_task())
        wanted = task is not None and task.state == "executing"
        if not wanted or worker.status not in (Status.running, Status.paused):
            raise AbandonedError(f"trial {number} was given up")


def _require_fit(there: Path, expected: Mapping[str, str]) -> None:
    worker, installed = get_worker(), versions()
    if worker.state.nthreads != 1:
        raise UsageError(
            f"worker {worker.address} has {worker.state.nthreads} threads, which share what a "
            "trial needs for itself: start it with --nthreads 1"
        )
    if not there.exists():
        raise UsageError(
            f"worker {worker.address} does not see the files in {there.parent}: what it learned "
            "would be elsewhere"
        )
    for package in {**installed, **expected}:
        theirs, ours = installed.get(package, "none"), expected.get(package, "none")
        if theirs != ours:
            raise UsageError(
                f"worker {worker.address} has {package} {theirs}, not {ours}: it might learn "
                "something else"
            )


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
