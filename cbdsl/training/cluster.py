"""Many trials at once, on a Dask cluster."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from pathlib import Path

from distributed import Client, KilledWorker, LocalCluster, as_completed

from cbdsl.errors.errors import UsageError
from cbdsl.training.assignment import Assignment, carry_out_alone


def carry_out_all(
    assignments: Sequence[Assignment],
    workers: int,
    scheduler: str | None,
    on_done: Callable[[list[Path]], None],
) -> None:
    """Carry out trials side by side; what is learned does not depend on who learns it.

    A trial whose worker is killed goes on from its journal at another.

    Args:
        assignments: the trials.
        workers: processes of one thread each, here.
        scheduler: address of a cluster instead, whose workers see the same files.
        on_done: told the files that each trial wrote.

    Raises:
        UsageError: the cluster is not there, or its workers die again and again.
        JournalError, BackendError, SensorError, OSError: see ``Assignment.carry_out``.
    """
    if scheduler is not None:
        _carry_out(assignments, _connected(scheduler), on_done)
        return
    with LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        silence_logs=logging.CRITICAL,
    ) as cluster:
        _carry_out(assignments, Client(cluster), on_done)


def _connected(scheduler: str) -> Client:
    try:
        return Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise UsageError(f"--scheduler {scheduler}: nothing answers there ({error})") from error


def _carry_out(
    assignments: Sequence[Assignment], client: Client, on_done: Callable[[list[Path]], None]
) -> None:
    with client:
        futures = client.map(carry_out_alone, assignments, pure=False)
        try:
            for future in as_completed(futures):
                on_done(future.result())
        except KilledWorker as error:
            raise UsageError(f"workers died again and again ({error}); --resume goes on") from error
