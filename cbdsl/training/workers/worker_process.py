"""Process of a worker on this machine that runs the tasks of its pipe, all on one body."""

from __future__ import annotations

import pickle
import sys
from multiprocessing.connection import Connection
from typing import Any

from cbdsl.diagnostics.errors import UsageError
from cbdsl.training.task import AbandonedError, run_task
from cbdsl.training.task_observer import TaskObserver


class PipeCheck(TaskObserver[Any]):
    """Observer that ends a trial when the command that waits for it is gone.

    Args:
        pipe: Pipe to that command.
    """

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe

    def note(self, number: int, item: object) -> None:
        """Raise an error if the pipe was closed."""
        if self._pipe.poll():  # no message is sent meanwhile, so the pipe was closed
            raise AbandonedError(f"trial {number} was given up")


def serve(pipe: Connection) -> None:
    """Run tasks until the pipe is closed."""
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError):
            return
        outcome: object
        try:
            outcome = run_task(task, PipeCheck(pipe))
        except AbandonedError:
            return
        except Exception as error:
            outcome = _sendable(error)
        pipe.send(outcome)


def _sendable(error: Exception) -> Exception:
    """Return the error, or one of its text if it cannot be sent to another process."""
    try:
        # Some exceptions can be pickled but not restored, because their classes take other
        # arguments.
        pickle.loads(pickle.dumps(error))
    except Exception:
        if isinstance(error, UsageError):
            return UsageError(str(error))
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


def main() -> None:
    """Serve the pipe whose descriptor is the first word of the command line."""
    with Connection(int(sys.argv[1])) as connection:
        serve(connection)
