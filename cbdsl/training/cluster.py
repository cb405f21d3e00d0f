"""Jobs such as trials, side by side on a Dask cluster."""

from __future__ import annotations

import logging
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Protocol, TypeVar

import dask.config
from distributed import Client, Future, KilledWorker, LocalCluster, wait

from cbdsl.errors.errors import UsageError
from cbdsl.training.provenance import versions
from cbdsl.training.worker import Job, work

J = TypeVar("J", bound=Job)
J_contra = TypeVar("J_contra", contravariant=True)

# How often a supervisor hears that time passes, s.
_PERIOD = 1.0
# How long a cluster may be without workers: those of a busy machine room may have to queue, s.
_PATIENCE = 900.0
# Libraries with threads of their own: there are as many workers as there is to be work at once.
_ONE_THREAD = dict.fromkeys(("OPENCV_FOR_THREADS_NUM", "NUMBA_NUM_THREADS"), "1")
# Dask watches its processes closely, up to a hundred times a second in each, which took a tenth of
# a worker's processor and more. Nobody looks at what it sees, nor at its pages.
_UNWATCHED = {
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "5s",
    "distributed.worker.http.routes": [],
    "distributed.scheduler.http.routes": [],
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.admin.system-monitor.gil.enabled": False,
}
# No lines about workers that come and go: the supervisor hears of them.
_LOGGERS = ("distributed", "distributed.client", "distributed.core", "tornado.application")
# Names the authority whose signature lets one in.
_CA_FILE = "DASK_DISTRIBUTED__COMM__TLS__CA_FILE"
_GONE = "the cluster's scheduler is gone, or gave the trials up"


class Supervisor(Protocol[J_contra]):
    """Observer of jobs that run on a cluster."""

    def done(self, job: J_contra, files: Sequence[Path], /) -> None:
        """A job ended and wrote these files."""
        ...

    def failed(self, job: J_contra, error: Exception, /) -> None:
        """A job failed; the others go on."""
        ...

    def look(self, workers: int) -> None:
        """Called every second with the number of workers."""
        ...


def run_all(
    jobs: Sequence[J],
    workers: int,
    scheduler: str | None,
    supervisor: Supervisor[J],
    patience: float = _PATIENCE,
) -> None:
    """Run jobs side by side; outcomes do not depend on the workers.

    A trial whose worker is killed goes on from its journal at another.

    Args:
        jobs: such as trials.
        workers: processes of one thread each, here.
        scheduler: address of a cluster instead, whose workers see the same files.
        supervisor: observer of their outcomes.
        patience: for how long there may be no worker at all, s.

    Raises:
        UsageError: the cluster is not there, goes away, or has no workers for too long.
    """
    folder = jobs[0].path.parent
    with (
        _silence(),
        _connected(workers, scheduler) as client,
        NamedTemporaryFile(dir=folder, prefix=".cb_learn_") as there,
    ):
        given = versions()
        futures = {
            client.submit(work, each, Path(there.name), given, pure=False): each for each in jobs
        }
        _supervise(futures, client, supervisor, patience)


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
    """Client of a scheduler.

    Raises:
        UsageError: none is reached, or it does not let this one in.
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
        problem = "what answers there is no scheduler of Dask"
    except TypeError:  # as Dask says that it lacks certificates
        problem = f"TLS needs certificates, which Dask's settings name, such as {_CA_FILE}"
    except RuntimeError as error:
        if "encryption required" not in str(error):
            raise
        problem = "Dask's settings require encryption, and this address has none; write tls://"
    raise UsageError(f"--scheduler {scheduler}: {problem}")


def _absent_certificates() -> list[str]:
    """Files of certificates that Dask's settings name and that are not there."""
    keys = ("ca-file", "client.cert", "client.key")
    named = (dask.config.get(f"distributed.comm.tls.{key}", None) for key in keys)
    return [
        name for name in named if name and "-----BEGIN" not in name and not Path(name).is_file()
    ]


@contextmanager
def _connected(workers: int, scheduler: str | None) -> Iterator[Client]:
    if scheduler is not None:
        with _client(scheduler) as client:
            yield client
        return
    with dask.config.set(_UNWATCHED), ExitStack() as begun:
        with _interrupts_put_off():
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address=None,
                # Any free port: the usual one may be another cluster's, which Dask would warn of.
                scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
                silence_logs=logging.CRITICAL,
                env=_ONE_THREAD,
                preload="cbdsl.training.worker",
            )
            begun.enter_context(cluster)
        yield begun.enter_context(Client(cluster))


@contextmanager
def _interrupts_put_off() -> Iterator[None]:
    """Have Ctrl-C and SIGTERM wait until a cluster has begun: Dask cannot end half of one.

    Ctrl-C goes to all processes of a terminal, and workers that are still importing would each
    print where that was. They inherit that the signal is blocked, and never hear of it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # where no signal comes
        return
    came: list[int] = []
    resource_tracker.ensure_running()  # which would unblock the signal at its first use
    handler = signal.signal(signal.SIGTERM, lambda number, _: came.append(number))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, handler)
        try:
            for number in came:
                signal.raise_signal(number)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _supervise(
    futures: dict[Future[list[Path]], J],
    client: Client,
    supervisor: Supervisor[J],
    patience: float,
) -> None:
    """Wait for all jobs, as long as there are workers."""
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
    """Number of workers of a cluster.

    Raises:
        UsageError: there is no cluster any more.
    """
    try:
        if client.status == "running":
            return len(client.nthreads())
    except OSError:
        pass
    raise UsageError(_GONE)


def _hand_over(future: Future[list[Path]], job: J, supervisor: Supervisor[J]) -> None:
    """Report the outcome of a job."""
    try:
        files = future.result()
    except CancelledError as error:
        raise UsageError(_GONE) from error
    except KilledWorker:
        died = UsageError("the workers that it was given to died, one after the other")
        supervisor.failed(job, died)
    except (UsageError, OSError, ImportError) as error:
        supervisor.failed(job, error)
    else:
        supervisor.done(job, files)
