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
        """A job ended and wrote these files."""
        ...

    def failed(self, job: J_contra, error: Exception, /) -> None:
        """A job failed; the others go on."""
        ...

    def look(self, workers: int) -> None:
        """Called every second with the number of workers."""
        ...
