"""Parallel tasks: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from cbdsl.training.task import Task
from cbdsl.training.workers.local_workers import Supervisor, run_on_workers

J = TypeVar("J", bound=Task)


def run_all(
    tasks: Sequence[J], workers: int, scheduler: str | None, supervisor: Supervisor[J]
) -> None:
    """Run tasks in parallel; outcomes do not depend on the workers.

    Args:
        tasks: Tasks, such as trials.
        workers: Number of processes of one thread each, on this machine.
        scheduler: Address of a cluster instead, whose workers see the same files.
        supervisor: Observer of their outcomes.

    Raises:
        UsageError: If the cluster is not there, goes away, or has no workers for too long.
        ModuleNotFoundError: If the cluster needs a package that is not installed.
    """
    if scheduler is None:
        run_on_workers(tasks, workers, supervisor)
        return
    from cbdsl.training.workers.cluster import run_on_cluster

    run_on_cluster(tasks, scheduler, supervisor)
