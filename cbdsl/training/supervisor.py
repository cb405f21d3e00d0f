"""Observer of jobs that run in other processes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, TypeVar

from cbdsl.training.job import Job

J_contra = TypeVar("J_contra", contravariant=True, bound=Job)


class Supervisor(Protocol[J_contra]):
    """Observer of jobs that run in other processes."""

    def done(self, job: J_contra, files: Sequence[Path], /) -> None:
        """Note that a job ended and wrote these files."""
        ...

    def failed(self, job: J_contra, error: Exception, /) -> None:
        """Note that a job failed; the others go on."""
        ...

    def look(self, workers: int) -> None:
        """Note the number of workers; called every second."""
        ...
