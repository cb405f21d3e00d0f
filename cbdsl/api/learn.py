"""``cbdsl.learn``: a policy from episodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.api.requests.declaration import engine_of, verb
from cbdsl.api.requests.learn_request import LearnRequest
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.learning.experience import Experience
    from cbdsl.training.learning_task import LearningTask


@dataclass(frozen=True)
class LearningOutcome:
    """Knowledge from one trial.

    Attributes:
        policy: File of the policy, for ``load(..., policy=...)``.
        files: All written documents, of the policy and of internal models.
        episodes: Experience of each episode, in order.
    """

    policy: Path
    files: tuple[Path, ...]
    episodes: tuple[Experience, ...]

    @property
    def rewarded(self) -> tuple[bool, ...]:
        """True for each rewarded episode, in order."""
        return tuple(any(each.reward for each in one.transitions) for one in self.episodes)


@verb(LearnRequest)
def learn(request: LearnRequest) -> LearningOutcome:
    """Learn a policy for a program from scratch, in this process.

    A file beside the policy's holds each episode as soon as it is over. With ``resume`` an
    interrupted trial continues, with the same result as without an interruption. With the learner
    ``assimilate`` the resources of a learned policy are learned, and ``out`` holds a schema.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or a file is in the way.
        OSError: A document cannot be written.
    """
    if request.trials != 1:
        raise UsageError(f"learn runs one trial, learn_trials runs {request.trials}")
    (outcome,) = learn_trials(request)
    return outcome


def learn_trials(
    request: LearnRequest, *, workers: int = 1, scheduler: str | None = None
) -> list[LearningOutcome]:
    """Run all trials of a request; the outcome does not depend on the workers.

    Args:
        request: Trials with all their inputs.
        workers: Number of parallel processes of one thread each; 1 for this process.
        scheduler: Address of a Dask cluster to use instead, whose workers see the same files.

    Raises:
        DiagnosticsError, UsageError, OSError: As ``learn``.
    """
    # Chosen once, so that the opened robot and the provenance of all trials have the same engine.
    request = replace(request, backend=engine_of(request))
    tasks = request.tasks()
    for task in tasks:
        task.require_ready(resume=request.resume)
    # The episodes of one trial depend on each other, so that a single trial gains nothing from
    # workers.
    if scheduler is None and (workers == 1 or len(tasks) == 1):
        return _in_this_process(request, tasks)
    from cbdsl.training.side_by_side import run_all

    supervisor = _Supervisor()
    run_all(tasks, min(workers, len(tasks)), scheduler, supervisor)
    if supervisor.errors:
        raise supervisor.errors[0]
    return [supervisor.outcome(task) for task in tasks]


def _in_this_process(request: LearnRequest, tasks: Sequence[LearningTask]) -> list[LearningOutcome]:
    from cbdsl.api.open_robot import open_robot
    from cbdsl.training.task_observer import ItemListener

    outcomes = []
    with open_robot(request.run, backend=request.backend, cameras=request.cameras) as robot:
        for task in tasks:
            listener = ItemListener(request.on_episode or _ignore)
            files = task.run(robot.backend, robot.kinematics, listener)
            outcomes.append(LearningOutcome(task.path, tuple(files), tuple(listener.items)))
    return outcomes


def _ignore(_: object) -> None:
    """Ignore an episode."""


class _Supervisor:
    """Supervisor that keeps the files of finished trials, and the errors of failed ones."""

    def __init__(self) -> None:
        self.errors: list[Exception] = []
        self._files: dict[Path, tuple[Path, ...]] = {}

    def done(self, job: LearningTask, files: Sequence[Path], /) -> None:
        """Keep the files of a trial; see ``Supervisor.done``."""
        self._files[job.path] = tuple(files)

    def failed(self, job: LearningTask, error: Exception, /) -> None:
        """Keep the error of a trial; see ``Supervisor.failed``."""
        self.errors.append(error)

    def look(self, workers: int) -> None:
        """Ignore the number of workers; see ``Supervisor.look``."""

    def outcome(self, task: LearningTask) -> LearningOutcome:
        """Return the outcome of a trial, with its episodes from the journal."""
        from cbdsl.learning.experience import EPISODES
        from cbdsl.storage.journal_follower import JournalFollower

        # A resumed journal may hold more episodes than this call requests.
        episodes = JournalFollower(task.journal, EPISODES).poll()[: task.episodes]
        return LearningOutcome(task.path, self._files[task.path], tuple(episodes))
