"""Parallel tasks, such as trials, on a Dask cluster."""

from __future__ import annotations

import logging
import os
import secrets
import socket
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

import dask.config
from distributed import Client, Future, KilledWorker, get_worker, wait
from distributed.core import Status

from cbdsl.extend.cluster import (
    AbandonedError,
    Supervisor,
    Task,
    TaskObserver,
    UsageError,
    run_task,
    versions,
)

J = TypeVar("J", bound=Task)

# Period of the supervisor's calls, s.
_PERIOD = 1.0
# Longest time of a cluster without workers, s; workers of a busy cluster may have to queue.
_PATIENCE = 900.0
# Loggers of workers that come and go; the supervisor is notified of them.
_LOGGERS = ("distributed", "distributed.client", "distributed.core", "tornado.application")
# Setting of the certificate authority that both ends trust.
_CA_FILE = "DASK_DISTRIBUTED__COMM__TLS__CA_FILE"
_MARKER = ".cb_learn_"
_GONE = "the cluster's scheduler is gone, or gave the trials up"


def run_on_cluster(
    tasks: Sequence[J], scheduler: str, supervisor: Supervisor[J], patience: float = _PATIENCE
) -> None:
    """Run tasks on a cluster; outcomes do not depend on its workers.

    A trial whose worker is killed continues from its journal on another worker.

    Args:
        tasks: Tasks, such as trials.
        scheduler: Address of a cluster whose workers see the same files.
        supervisor: Observer of their outcomes.
        patience: Longest time without any worker, s.

    Raises:
        UsageError: If the cluster is not there, goes away, or has no workers for too long.
    """
    folder = tasks[0].path.parent
    with (
        _silence(),
        _client(scheduler) as client,
        _marker(folder) as there,
    ):
        given = versions()
        # Without pure=False, Dask would return an earlier result for equal arguments.
        futures = {client.submit(work, each, there, given, pure=False): each for each in tasks}
        _supervise(futures, client, supervisor, patience)


@contextmanager
def _marker(folder: Path) -> Iterator[Path]:
    """Yield a file by which workers recognise a folder; remove the files of killed commands."""
    for left in folder.glob(f"{_MARKER}*"):
        if not _is_running(left.name.removeprefix(_MARKER)):
            left.unlink(missing_ok=True)
    marker = folder / f"{_MARKER}{socket.gethostname()}_{os.getpid()}_{secrets.token_hex(4)}"
    marker.touch(exist_ok=False)
    try:
        yield marker
    finally:
        marker.unlink(missing_ok=True)


def _is_running(owner: str) -> bool:
    """Return whether the owner of a marker may still run; owners on other hosts always may."""
    # The name of a host may contain underscores, so the parts are split off from the right.
    host, _, rest = owner.rpartition("_")[0].rpartition("_")
    if host != socket.gethostname() or not rest.isdigit():
        return True
    # Numbers of processes are reused: a marker may stay too long, but is not removed too early.
    return Path("/proc", rest).exists()


@contextmanager
def _silence() -> Iterator[None]:
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _client(scheduler: str) -> Client:
    """Return the client of a scheduler.

    Raises:
        UsageError: If no scheduler answers, or it refuses the connection.
    """
    absent = _absent_certificates() if scheduler.startswith("tls://") else []
    if absent:
        raise UsageError(f"--scheduler {scheduler}: there is no file {', '.join(absent)}")
    try:
        return Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        problem = f"nothing answers there ({error})"
        if "certificate" in str(error):
            problem = (
                f"the certificates of both ends are not signed by the same authority ({_CA_FILE})"
            )
    except MemoryError:  # Dask takes the first bytes of an answer for its length
        problem = "the server at this address is not a Dask scheduler"
    except TypeError:  # Dask's error for missing certificates
        problem = f"TLS needs certificates, which Dask's settings name, such as {_CA_FILE}"
    except RuntimeError as error:
        if "encryption required" not in str(error):
            raise
        problem = "Dask's settings require encryption, and this address has none; write tls://"
    raise UsageError(f"--scheduler {scheduler}: {problem}")


def _absent_certificates() -> list[str]:
    """Return the certificate files that Dask's settings name and that do not exist."""
    keys = ("ca-file", "client.cert", "client.key")
    named = (dask.config.get(f"distributed.comm.tls.{key}", None) for key in keys)
    return [
        name for name in named if name and "-----BEGIN" not in name and not Path(name).is_file()
    ]


def _supervise(
    futures: dict[Future[list[Path]], J],
    client: Client,
    supervisor: Supervisor[J],
    patience: float,
) -> None:
    """Wait for all tasks, while there are workers."""
    last_seen = time.monotonic()
    while futures:
        workers = _workers(client)
        supervisor.look(workers)
        if workers:
            last_seen = time.monotonic()
        elif time.monotonic() > last_seen + patience:
            raise UsageError(f"the cluster was without workers for {patience:.0f} s")
        with suppress(TimeoutError, CancelledError):
            wait(list(futures), timeout=_PERIOD, return_when="FIRST_COMPLETED")
        for future in [each for each in futures if each.done()]:
            _hand_over(future, futures.pop(future), supervisor)


def _workers(client: Client) -> int:
    """Return the number of workers of a cluster.

    Raises:
        UsageError: If the cluster is gone.
    """
    try:
        if client.status == "running":
            return len(client.nthreads())
    except OSError:
        pass
    raise UsageError(_GONE)


def _hand_over(future: Future[list[Path]], task: J, supervisor: Supervisor[J]) -> None:
    """Report the outcome of a task."""
    try:
        files = future.result()
    except CancelledError as error:
        raise UsageError(_GONE) from error
    except KilledWorker:
        died = UsageError("the workers that it was given to died, one after the other")
        supervisor.failed(task, died)
    except (UsageError, OSError, ImportError) as error:
        supervisor.failed(task, error)
    else:
        supervisor.done(task, files)


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
