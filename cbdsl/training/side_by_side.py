"""Parallel jobs: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from cbdsl.training.job import Job
from cbdsl.training.local_workers import run_on_workers
from cbdsl.training.supervisor import Supervisor

J = TypeVar("J", bound=Job)


def run_all(
    jobs: Sequence[J], workers: int, scheduler: str | None, supervisor: Supervisor[J]
) -> None:
    """Run jobs in parallel; outcomes do not depend on the workers.

    Args:
        jobs: Jobs, such as trials.
        workers: Number of processes of one thread each, on this machine.
        scheduler: Address of a cluster instead, whose workers see the same files.
        supervisor: Observer of their outcomes.

    Raises:
        UsageError: If the cluster is not there, goes away, or has no workers for too long.
        ModuleNotFoundError: If the cluster needs a package that is not installed.
    """
    if scheduler is None:
        run_on_workers(jobs, workers, supervisor)
        return
    from cbdsl.training.cluster import run_on_cluster

    run_on_cluster(jobs, scheduler, supervisor)
