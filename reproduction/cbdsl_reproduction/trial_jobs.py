"""Trial jobs of an experiment that learns: run side by side, with progress."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl_reproduction.experiment import Experiment, RunSettings
    from cbdsl_reproduction.trial_job import TrialJob


def run_jobs(experiment: Experiment, settings: RunSettings, workers: int) -> None:
    """Run all episodes of an experiment in other processes, and keep them in its folder.

    Args:
        experiment: Experiment in which the robot learns.
        settings: Settings of the experiment.
        workers: Number of processes.

    Raises:
        UsageError: A job failed; finished episodes are kept.
    """
    from cbdsl.api.trials import find_backend, run_on_workers
    from cbdsl_reproduction.trial_job import trial_jobs

    find_backend(settings.backend)
    with trial_jobs(experiment, settings) as jobs:
        supervision = _Supervision(jobs, settings)
        if len(jobs) > 1:  # a single job cannot be parallelized
            run_on_workers(jobs, min(workers, len(jobs)), supervision)
    supervision.conclude()


class _Supervision:
    """Supervisor that reports the progress of jobs in other processes; see ``Supervisor``.

    Args:
        jobs: All jobs.
        settings: Settings with the progress callback.
    """

    def __init__(self, jobs: Sequence[TrialJob], settings: RunSettings) -> None:
        self._jobs, self._settings = jobs, settings
        self._failures: list[Exception] = []

    def look(self, workers: int) -> None:
        """Report the progress; see ``Supervisor.look``."""
        progress = [job.progress() for job in self._jobs]
        # A job that has not begun has as many episodes as any other.
        total = max(total for _, total in progress)
        if total:
            self._settings.progress(sum(done for done, _ in progress), total * len(progress))

    def done(self, job: TrialJob, files: Sequence[Path], /) -> None:
        """Ignore a finished job; see ``Supervisor.done``."""

    def failed(self, job: TrialJob, error: Exception, /) -> None:
        """Record the error of a job; see ``Supervisor.failed``."""
        self._failures.append(error)

    def conclude(self) -> None:
        """Raise the first error at the end.

        Raises:
            Exception: Error that a job raised.
        """
        if self._failures:
            raise self._failures[0]
