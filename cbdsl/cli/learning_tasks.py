"""Learning tasks of ``cb learn``, run in a row or side by side, with their progress."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.cli.episodes.live import live_page
from cbdsl.cli.episodes.simulation import needing_simulation, simulation
from cbdsl.cli.output.learning_progress import LearningProgress
from cbdsl.cli.output.terminal import print_line, print_problem
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.learning.experience import EPISODES
from cbdsl.storage.journal import JournalError
from cbdsl.storage.journal_follower import JournalFollower

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.cli.episodes.live import LiveOptions
    from cbdsl.learning.experience import Experience
    from cbdsl.training.learning_task import LearningTask

# Workers that take longer to begin are likely to compile, s.
_QUIET = 8.0


def one_by_one(tasks: Sequence[LearningTask], request: RunRequest, live: LiveOptions) -> None:
    """Run trials in this process.

    Args:
        tasks: Learning tasks, one per trial.
        request: Program, robot and stage.
        live: Options of the live page.

    Raises:
        UsageError: A trial failed; the message names the reason and the kept files.
    """
    with (
        simulation(request, tasks[0].backend, cameras=tasks[0].cameras) as (body, kinematics),
        live_page(live, request, body) as page,
        _progress(tasks, at_once=1) as progress,
    ):
        for task in tasks:
            with _explained(task):
                files = task.run(body, kinematics, progress, page)
            _print_files(files)


def side_by_side(tasks: Sequence[LearningTask], workers: int, scheduler: str | None) -> None:
    """Run trials in other processes.

    Args:
        tasks: Learning tasks, one per trial.
        workers: Number of processes.
        scheduler: Address of a cluster to use instead of processes, or ``None``.

    Raises:
        UsageError: Trials failed; the message names the reasons and the kept files.
    """
    with needing_simulation():
        from cbdsl.backends.backend import find_backend

        # An unknown backend fails once here, and not in each worker.
        find_backend(tasks[0].backend)
    from cbdsl.training.side_by_side import run_all

    with _progress(tasks, at_once=workers) as progress, _explained(*tasks):
        supervision = Supervision(tasks, progress)
        run_all(tasks, workers, scheduler, supervision)
    supervision.conclude()


class Supervision:
    """Supervisor that prints the progress of trials from their journals.

    Args:
        tasks: Learning tasks of the trials.
        progress: Progress display that is notified of their episodes.
    """

    def __init__(self, tasks: Sequence[LearningTask], progress: LearningProgress) -> None:
        self._progress = progress
        self._workers = -1
        self._failures: dict[str, list[int]] = {}
        self._quiet_until = time.monotonic() + _QUIET
        self._followers = [(each, JournalFollower(each.journal, EPISODES)) for each in tasks]
        for task, follower in self._followers:
            # A journal may hold more episodes than this call requests.
            finished = follower.poll()[: task.episodes]
            if follower.identity:
                progress.begin(task.number, follower.identity["renderer"], finished)

    def look(self, workers: int) -> None:
        """Report new episodes; see ``Supervisor.look``."""
        if workers != self._workers:
            self._workers = workers
            self._progress.at_once = max(1, min(workers, len(self._followers)))
            print(f"workers: {workers}" if workers else "no workers: waiting for some", flush=True)
        seen = sum([self._read(*each) for each in self._followers])
        # Without workers nothing compiles, so that the waiting time starts later. After an episode,
        # the hint is never due.
        if workers == 0 or seen:
            self._quiet_until = time.monotonic() + _QUIET if workers == 0 else float("inf")
        elif time.monotonic() > self._quiet_until:
            self._quiet_until = float("inf")
            print("no episode is over yet; after an installation, workers compile at first")

    def _read(self, task: LearningTask, follower: JournalFollower[Experience]) -> int:
        """Report the episodes of a trial that ended since the last poll; return their number."""
        was_begun, number = bool(follower.identity), task.number
        episodes = follower.poll()
        if follower.identity and not was_begun:
            self._progress.begin(number, follower.identity["renderer"], [])
        for episode in episodes:
            self._progress.note(number, episode)
        return len(episodes)

    def done(self, task: LearningTask, files: Sequence[Path]) -> None:
        """Report the files of a trial; see ``Supervisor.done``."""
        self.look(self._workers)  # episodes are reported before the files that hold them
        _print_files(files)

    def failed(self, task: LearningTask, error: Exception) -> None:
        """Report a failed trial; see ``Supervisor.failed``."""
        reason = _reason(task, error)
        self._failures.setdefault(reason, []).append(task.number)
        print_line(f"trial {task.number} cannot go on: {reason}")

    def conclude(self) -> None:
        """Raise the failures of all trials at the end.

        Raises:
            UsageError: A trial failed.
        """
        failures = [
            f"trial {', '.join(map(str, numbers))}: {reason}"
            for reason, numbers in self._failures.items()
        ]
        if failures:
            raise UsageError("; ".join(failures) + "; --resume runs the missing trials")


def _progress(tasks: Sequence[LearningTask], at_once: int) -> LearningProgress:
    first, count = tasks[0], len(tasks)
    title = f"{first.program.name} on {first.stage.name}, seed {first.seed}"
    if count > 1:
        title = f"{title}, {count} trials"
    return LearningProgress(title, count, first.episodes, at_once)


@contextmanager
def _explained(*tasks: LearningTask) -> Iterator[None]:
    """Convert errors and interrupts of trials to one message that names the kept files."""
    try:
        yield
    # Nothing can continue from an unusable journal, so that its message gets no such promise.
    except JournalError:
        raise
    except (UsageError, OSError) as error:
        raise UsageError(_reason(tasks[0], error) + _kept(tasks)) from error
    except KeyboardInterrupt:
        print_problem(f"interrupted{_kept(tasks)}")
        raise


def _reason(task: LearningTask, error: Exception) -> str:
    if isinstance(error, OSError):
        return f"{error.filename or task.path}: {reason(error)}"
    return str(error)


def _kept(tasks: Sequence[LearningTask]) -> str:
    """Return a clause that names the journals of finished episodes."""
    journals = [each.journal for each in tasks if each.journal.exists()]
    if not journals:
        return ""
    more = f" and {len(journals) - 1} more" if len(journals) > 1 else ""
    return f"; finished episodes are kept in {journals[0]}{more}: --resume continues them"


def _print_files(files: Sequence[Path]) -> None:
    for file in files:
        print_line(f"wrote {file}")
