"""A worker of a cluster: carries out one trial after another, on one body for all of them."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from distributed import Worker, get_worker
from distributed.core import Status

from cbdsl.backends.backend import Backend, find_backend
from cbdsl.documents.digest import digest
from cbdsl.errors.errors import UsageError
from cbdsl.learning.experience import Experience
from cbdsl.robot.kinematics import Kinematics
from cbdsl.training.assignment import Assignment
from cbdsl.training.provenance import versions

Workplace = tuple[Backend, Kinematics]

# To put a body together takes as long as some episodes. A process has one thread and one robot.
_kept: dict[tuple[str, str, Path], Workplace] = {}


class AbandonedError(UsageError):
    """Nobody waits for the outcome of a trial any more."""


def dask_setup(_: Worker) -> None:
    """Leave Ctrl-C to the command that started this process; Dask calls this at its start."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def work(assignment: Assignment, there: Path, expected: Mapping[str, str]) -> list[Path]:
    """Carry out a trial, here and now; see ``Assignment.carry_out``.

    Args:
        assignment: the trial.
        there: a file that whoever asks for it sees.
        expected: versions of what the outcome depends on.

    Returns:
        The files that were written.

    Raises:
        UsageError: this worker would learn something else, or put it elsewhere.
        JournalError, BackendError, EpisodeError, OSError: see ``Assignment.carry_out``.
    """
    _require_fit(there, expected)
    with _workplace(assignment) as (body, kinematics):
        return assignment.carry_out(body, kinematics, _Conscience())


class _Conscience:
    """Ends a trial that nobody waits for, so that somebody else can go on with it."""

    def begin(self, number: int, renderer: str, finished: Sequence[Experience]) -> None:
        """See ``Watcher.begin``."""

    def note(self, number: int, experience: Experience, seconds: float) -> None:
        """See ``Watcher.note``."""
        worker = get_worker()
        task = worker.state.tasks.get(worker.get_current_task())
        wanted = task is not None and task.state == "executing"
        if not wanted or worker.status not in (Status.running, Status.paused):
            raise AbandonedError(f"trial {number} was given up")


def _require_fit(there: Path, expected: Mapping[str, str]) -> None:
    worker, found = get_worker(), versions()
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
    for package in {**found, **expected}:
        theirs, ours = found.get(package, "none"), expected.get(package, "none")
        if theirs != ours:
            raise UsageError(
                f"worker {worker.address} has {package} {theirs}, not {ours}: it might learn "
                "something else"
            )


@contextmanager
def _workplace(assignment: Assignment) -> Iterator[Workplace]:
    """The body for a trial, put together for the first one of its kind."""
    key = (assignment.backend, digest(assignment.robot), assignment.urdf)
    if key not in _kept:
        body = find_backend(assignment.backend)(assignment.robot, assignment.urdf)
        _kept[key] = body, Kinematics(assignment.robot, assignment.urdf)
    try:
        yield _kept[key]
    except BaseException:
        # Who knows what state it is in.
        _kept.pop(key)[0].close()
        raise
