"""Workers on this machine: processes that are reached over their own pipes alone.

No port is opened, so that no other user of the machine can reach them.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from cbdsl.diagnostics.errors import UsageError
from cbdsl.training.task import Task

J = TypeVar("J", bound=Task)

# Period of the supervisor's calls, s.
_PERIOD = 1.0
# Number of workers that may die of one task before it fails.
_MOST_DEATHS = 4
# Longest time in which workers may end, s.
_PATIENCE = 5.0
# Libraries with threads of their own; workers already use one core each.
_ONE_THREAD = dict.fromkeys(("OPENCV_FOR_THREADS_NUM", "NUMBA_NUM_THREADS"), "1")

_BEGIN = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[2]); "
    "from cbdsl.numeric.numba_settings import ignore_settings_of_folder; "
    "ignore_settings_of_folder(); "
    "from cbdsl.training.workers.worker_process import main; main()"
)


def run_on_workers(tasks: Sequence[J], workers: int, supervisor: Supervisor[J]) -> None:
    """Run tasks in processes of this machine; outcomes do not depend on their number.

    A task whose worker is killed continues from its journal on another worker.

    Args:
        tasks: Tasks, such as trials.
        workers: Number of processes of one thread each.
        supervisor: Observer of their outcomes.
    """
    with _Pool[J](tasks, supervisor).running(workers) as pool:
        while pool.goes_on():
            supervisor.look(pool.size)
            pool.advance()


class _Worker(Generic[J]):
    """A process and the pipe to it.

    Attributes:
        pipe: This end of the pipe.
        task: Present task, or ``None``.
    """

    def __init__(self) -> None:
        self.pipe, other_end = Pipe()
        self.task: J | None = None
        # This process closes its copy of the other end. Otherwise the pipe would stay open when the
        # worker dies, and its death would not be noticed.
        with other_end, _interrupts_blocked():
            paths = json.dumps([path for path in sys.path if path])
            # -P: no module of the current folder replaces an imported one.
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _BEGIN, str(other_end.fileno()), paths],
                pass_fds=(other_end.fileno(),),
                stdin=subprocess.DEVNULL,
                env={**os.environ, **_ONE_THREAD},
            )

    def end(self) -> None:
        """Begin to end the process by closing its pipe."""
        self.pipe.close()
        self._process.terminate()

    def join(self, until: float) -> None:
        """Wait for the process to end, until a time of the monotonic clock, then kill it."""
        try:
            self._process.wait(max(0.0, until - time.monotonic()))
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


class _Pool(Generic[J]):
    """Workers with tasks, and tasks without workers.

    Args:
        tasks: Tasks to run.
        supervisor: Observer of their outcomes.
    """

    def __init__(self, tasks: Sequence[J], supervisor: Supervisor[J]) -> None:
        self._waiting = deque(tasks)
        self._deaths = dict.fromkeys(map(id, tasks), 0)
        self._supervisor = supervisor
        self._workers: list[_Worker[J]] = []

    @property
    def size(self) -> int:
        """Number of workers."""
        return len(self._workers)

    @contextmanager
    def running(self, workers: int) -> Iterator[_Pool[J]]:
        """Start workers; end them when the context is left."""
        try:
            for _ in range(min(workers, len(self._waiting))):
                self._workers.append(_Worker())
                self._assign(self._workers[-1])
            yield self
        finally:
            # All workers are asked to end before the first is waited for, so that they end in
            # parallel.
            for worker in self._workers:
                worker.end()
            until = time.monotonic() + _PATIENCE
            for worker in self._workers:
                worker.join(until)

    def goes_on(self) -> bool:
        """Return whether any task is not over."""
        return bool(self._waiting) or any(worker.task is not None for worker in self._workers)

    def advance(self) -> None:
        """Report the outcomes of the next period, and assign the waiting tasks."""
        pipes = {worker.pipe: worker for worker in self._workers}
        for pipe in wait(list(pipes), _PERIOD):
            assert isinstance(pipe, Connection)
            worker = pipes[pipe]
            try:
                outcome = worker.pipe.recv()
            except (EOFError, OSError):
                self._replace(worker)
                continue
            # The worker gets its next task before the outcome is reported, so that it need not wait
            # for the supervisor.
            task, worker.task = worker.task, None
            self._assign(worker)
            if task is not None:
                self._report(task, outcome)

    def _assign(self, worker: _Worker[J]) -> None:
        if self._waiting:
            worker.task = self._waiting.popleft()
            with suppress(OSError):  # it died; its pipe reports that in the next period
                worker.pipe.send(worker.task)

    def _replace(self, worker: _Worker[J]) -> None:
        """Replace a dead worker by another with the same task."""
        worker.end()
        worker.join(time.monotonic() + _PATIENCE)
        self._workers.remove(worker)
        task = worker.task
        if task is not None:
            self._deaths[id(task)] += 1
            # A task that takes too much memory would kill every worker, so the number of attempts
            # is limited.
            if self._deaths[id(task)] < _MOST_DEATHS:
                self._waiting.appendleft(task)
            else:
                died = UsageError("the workers that it was given to died, one after the other")
                self._supervisor.failed(task, died)
        if self._waiting:
            self._workers.append(_Worker())
            self._assign(self._workers[-1])

    def _report(self, task: J, outcome: list[Path] | Exception) -> None:
        if not isinstance(outcome, Exception):
            self._supervisor.done(task, outcome)
        elif isinstance(outcome, UsageError | OSError | ImportError):
            self._supervisor.failed(task, outcome)
        else:
            raise outcome


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C for processes begun here; the terminal sends it to all its processes."""
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


J_contra = TypeVar("J_contra", contravariant=True, bound=Task)


class Supervisor(Protocol[J_contra]):
    """Observer of tasks that run in other processes."""

    def done(self, task: J_contra, files: Sequence[Path], /) -> None:
        """Note that a task ended and wrote these files."""
        ...

    def failed(self, task: J_contra, error: Exception, /) -> None:
        """Note that a task failed; the others go on."""
        ...

    def look(self, workers: int) -> None:
        """Note the number of workers; called every second."""
        ...
