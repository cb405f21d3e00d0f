"""Tasks, such as trials, and the body that the tasks of one process share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from cbdsl.backends.backend import Backend, embody
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document_digest import digest
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.training.task_observer import TaskObserver

Workplace = tuple[Backend, Kinematics]

# Building a body takes as long as some episodes. A process has one thread and one robot.
_kept: dict[tuple[str, str | None, str, Path], Workplace] = {}


class Task(Protocol):
    """Work for a separate process; it can be sent to another process.

    Attributes:
        path: Path of a file in a folder that all workers see.
        robot: Robot whose body the task needs.
        urdf: Path of the robot's URDF model, the same for all workers.
        backend: Name of the backend.
        cameras: Kind of its cameras; ``None`` for the backend's default.
    """

    @property
    def path(self) -> Path: ...
    @property
    def robot(self) -> RobotDocument: ...
    @property
    def urdf(self) -> Path: ...
    @property
    def backend(self) -> str: ...
    @property
    def cameras(self) -> str | None: ...

    def run(self, body: Backend, kinematics: Kinematics, observer: TaskObserver[Any]) -> list[Path]:
        """Run the task on a body; the observer receives each finished item.

        Returns:
            Written files.
        """
        ...


class AbandonedError(UsageError):
    """Error of a cancelled trial."""


def run_task(task: Task, observer: TaskObserver[Any]) -> list[Path]:
    """Run a task in this process.

    Args:
        task: Task, such as a trial.
        observer: Observer that may end the task by an exception.

    Returns:
        Written files.

    Raises:
        JournalError, BackendError, EpisodeError, OSError: Errors of ``run_trial``.
    """
    with _workplace(task) as (body, kinematics):
        return task.run(body, kinematics, observer)


@contextmanager
def _workplace(task: Task) -> Iterator[Workplace]:
    """Yield the body for a task, built for the first one of its kind and kept."""
    # Robots of one name may differ in their documents, so the digest is a part of the key.
    key = (task.backend, task.cameras, digest(task.robot), task.urdf)
    if key not in _kept:
        body = embody(task.backend, task.robot, task.urdf, cameras=task.cameras)
        _kept[key] = body, Kinematics(task.robot, task.urdf)
    try:
        yield _kept[key]
    except BaseException:
        # The state of the body is unknown after an exception.
        _kept.pop(key)[0].close()
        raise
