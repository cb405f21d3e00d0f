"""Parallel tasks: in processes of this machine, or on a cluster."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, TypeVar

from cbdsl.training.task import Task
from cbdsl.training.workers.local_workers import Supervisor, run_on_workers
from cbdsl.types.registry import Registry, require_function

J = TypeVar("J", bound=Task)

Cluster: TypeAlias = Callable[[Sequence[Any], str, Supervisor[Any]], None]
"""Function that runs tasks on the cluster of an address, and reports to a supervisor."""


CLUSTERS: Registry[Cluster] = Registry(
    "cluster", "cbdsl.clusters", {}, require_function, providers={"dask": "cbdsl[learn]"}
)


def run_all(
    tasks: Sequence[J], workers: int, scheduler: str | None, supervisor: Supervisor[J]
) -> None:
    """Run tasks in parallel; outcomes do not depend on the workers.

    Args:
        tasks: Tasks, such as trials.
        workers: Number of processes of one thread each, on this machine.
        scheduler: Address of a Dask cluster instead, whose workers see the same files.
        supervisor: Observer of their outcomes.

    Raises:
        UsageError: If the cluster is not there or not installed, goes away, or has no workers for
            too long.
    """
    if scheduler is None:
        run_on_workers(tasks, workers, supervisor)
    else:
        CLUSTERS.get("dask")(tasks, scheduler, supervisor)
