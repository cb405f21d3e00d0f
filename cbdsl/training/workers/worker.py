"""Worker of a Dask cluster that runs one task after another, all on one body."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from distributed import get_worker
from distributed.core import Status

from cbdsl.diagnostics.errors import UsageError
from cbdsl.training.provenance import versions
from cbdsl.training.task import AbandonedError, Task, run_task
from cbdsl.training.task_observer import TaskObserver


def work(task: Task, there: Path, expected: Mapping[str, str]) -> list[Path]:
    """Run a task in this process.

    Args:
        task: Task, such as a trial.
        there: Path of a marker file that the client sees.
        expected: Expected versions of the packages that influence the outcome.

    Returns:
        Written files.

    Raises:
        UsageError: If this worker would learn different knowledge, or write it to another place.
        JournalError, BackendError, EpisodeError, OSError: Errors of ``run_trial``.
    """
    _require_fit(there, expected)
    return run_task(task, CancellationCheck())


class CancellationCheck(TaskObserver[Any]):
    """Observer that ends a cancelled trial, so that another worker can go on with it."""

    def note(self, number: int, item: object) -> None:
        """Raise an error if the trial was cancelled."""
        # Dask does not interrupt a running task, so a cancelled one has to notice it by itself.
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
    # Episodes depend on the versions of these packages, and one trial may run on several workers.
    for package in {**installed, **expected}:
        theirs, ours = installed.get(package, "none"), expected.get(package, "none")
        if theirs != ours:
            raise UsageError(
                f"worker {worker.address} has {package} {theirs}, not {ours}: it might learn "
                "something else"
            )
