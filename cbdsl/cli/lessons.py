"""Trials of ``cb learn``: carried out in a row or side by side, and told of."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.cli.learning_progress import LearningProgress
    from cbdsl.cli.order import Order
    from cbdsl.training.assignment import Assignment
    from cbdsl.training.onlooker import Onlooker

# Workers that take longer to begin are likely to compile, s.
_QUIET = 8.0


def one_by_one(assignments: Sequence[Assignment], order: Order) -> None:
    """Carry out trials in this process.

    Raises:
        UsageError: one cannot be carried out; the message says why, and what is kept.
    """
    from cbdsl.cli.simulation import simulation

    with (
        simulation(order, assignments[0].backend, cameras=assignments[0].cameras) as (
            body,
            kinematics,
        ),
        _progress(assignments, at_once=1) as progress,
    ):
        for assignment in assignments:
            with _explained(assignment):
                files = assignment.carry_out(body, kinematics, progress)
            _tell(files)


def side_by_side(assignments: Sequence[Assignment], workers: int, scheduler: str | None) -> None:
    """Carry out trials in other processes.

    Args:
        assignments: the trials.
        workers: how many processes.
        scheduler: address of a cluster that has some instead.

    Raises:
        UsageError: some could not be carried out; the message says why, and what is kept.
    """
    from cbdsl.cli.simulation import needing_simulation
    from cbdsl.errors.errors import UsageError

    with needing_simulation():
        from cbdsl.backends.backend import find_backend

        find_backend(assignments[0].backend)
    try:
        from cbdsl.training.cluster import carry_out_all
    except ModuleNotFoundError as error:
        option = "--scheduler" if scheduler else "--workers"
        raise UsageError(
            f"{option} needs {error.name}, which is not installed: pip install 'cbdsl[learn]'"
        ) from error
    with _progress(assignments, at_once=workers) as progress, _explained(*assignments):
        supervision = Supervision(assignments, progress)
        carry_out_all(assignments, workers, scheduler, supervision)
    supervision.conclude()


class Supervision:
    """Tells of trials that run elsewhere; see ``Supervisor``.

    Args:
        assignments: the trials.
        progress: is told of their episodes.
    """

    def __init__(self, assignments: Sequence[Assignment], progress: LearningProgress) -> None:
        from cbdsl.training.onlooker import Onlooker

        self._progress = progress
        self._workers = -1
        self._failures: dict[str, list[int]] = {}
        self._quiet_until = time.monotonic() + _QUIET
        self._onlookers = [(each, Onlooker(each.journal)) for each in assignments]
        for assignment, onlooker in self._onlookers:
            entries = onlooker.look()[: assignment.episodes]
            if onlooker.identity:
                finished = [entry.experience for entry in entries]
                progress.begin(assignment.number, onlooker.identity["renderer"], finished)

    def look(self, workers: int) -> None:
        """See ``Supervisor.look``."""
        if workers != self._workers:
            self._workers = workers
            self._progress.at_once = max(1, min(workers, len(self._onlookers)))
            print(f"workers: {workers}" if workers else "no workers: waiting for some", flush=True)
        seen = sum([self._read(*each) for each in self._onlookers])
        if workers == 0 or seen:
            self._quiet_until = time.monotonic() + _QUIET if workers == 0 else float("inf")
        elif time.monotonic() > self._quiet_until:
            self._quiet_until = float("inf")
            print("no episode is over yet; after an installation, workers compile at first")

    def _read(self, assignment: Assignment, onlooker: Onlooker) -> int:
        """Tell of the episodes of a trial that ended since the last look; how many."""
        was_begun, number = bool(onlooker.identity), assignment.number
        entries = onlooker.look()
        if onlooker.identity and not was_begun:
            self._progress.begin(number, onlooker.identity["renderer"], [])
        for entry in entries:
            self._progress.note(number, entry.experience, entry.wall_seconds)
        return len(entries)

    def done(self, assignment: Assignment, files: Sequence[Path]) -> None:
        """See ``Supervisor.done``."""
        self.look(self._workers)  # an episode is told before the files in which it is
        _tell(files)

    def failed(self, assignment: Assignment, error: Exception) -> None:
        """See ``Supervisor.failed``."""
        reason = _reason(assignment, error)
        self._failures.setdefault(reason, []).append(assignment.number)
        print(f"trial {assignment.number} cannot go on: {reason}", flush=True)

    def conclude(self) -> None:
        """At the end, say what is missing.

        Raises:
            UsageError: a trial failed.
        """
        from cbdsl.errors.errors import UsageError

        told = [
            f"trial {', '.join(map(str, numbers))}: {reason}"
            for reason, numbers in self._failures.items()
        ]
        if told:
            raise UsageError("; ".join(told) + "; --resume goes on with what is missing")


def _progress(assignments: Sequence[Assignment], at_once: int) -> LearningProgress:
    from cbdsl.cli.learning_progress import LearningProgress

    first, count = assignments[0], len(assignments)
    title = f"{first.program.name} on {first.stage.name}, seed {first.seed}"
    if count > 1:
        title = f"{title}, {count} trials"
    return LearningProgress(title, count, first.episodes, at_once)


@contextmanager
def _explained(*assignments: Assignment) -> Iterator[None]:
    """What keeps trials from their end, in words."""
    from cbdsl.cli.terminal import print_problem
    from cbdsl.errors.errors import UsageError
    from cbdsl.training.journal import JournalError

    try:
        yield
    except JournalError:
        raise
    except (UsageError, OSError) as error:
        raise UsageError(_reason(assignments[0], error) + _kept(assignments)) from error
    except KeyboardInterrupt:
        print_problem(f"interrupted{_kept(assignments)}")
        raise


def _reason(assignment: Assignment, error: Exception) -> str:
    from cbdsl.errors.reason import reason

    if isinstance(error, OSError):
        return f"{error.filename or assignment.path}: {reason(error)}"
    return str(error)


def _kept(assignments: Sequence[Assignment]) -> str:
    """Where the episodes are that are over."""
    journals = [each.journal for each in assignments if each.journal.exists()]
    if not journals:
        return ""
    more = f" and {len(journals) - 1} more" if len(journals) > 1 else ""
    return f"; what is over is kept in {journals[0]}{more}: --resume goes on with it"


def _tell(files: Sequence[Path]) -> None:
    for file in files:
        print(f"wrote {file}", flush=True)
