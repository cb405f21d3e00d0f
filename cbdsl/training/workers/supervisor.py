"""Observer of tasks that run in other processes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, TypeVar

from cbdsl.training.task import Task

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
