"""Progress of trials that run in other processes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from cbdsl.cli.learning_tasks import Supervision
from cbdsl.cli.output.learning_progress import LearningProgress
from cbdsl.diagnostics.errors import UsageError
from cbdsl.training.learning_task import LearningTask
from cbdsl.training.task_files import trial_journal
from tests.training.tasks import made_tasks
from tests.training.toy import take

EPISODES = 3


@pytest.fixture
def tasks(tmp_path: Path) -> list[LearningTask]:
    return made_tasks(tmp_path, 3, EPISODES)


def supervision(tasks: Sequence[LearningTask]) -> Supervision:
    progress = LearningProgress("searchtrack", len(tasks), EPISODES)
    return Supervision(tasks, progress)


def test_episodes_of_workers_are_reported_from_their_journals(
    tasks: list[LearningTask], capsys: pytest.CaptureFixture[str]
) -> None:
    take(tasks[0].path, EPISODES - 1)
    watching = supervision(tasks)
    watching.look(0)
    watching.look(2)
    take(tasks[0].path, EPISODES, resume=True)
    watching.done(tasks[0], [tasks[0].path])
    said = capsys.readouterr().out.splitlines()
    assert said[1] == "trial 0: 2 of 3 episodes are over"
    assert said[2:4] == ["no workers: waiting for some", "workers: 2"]
    assert said[4].startswith("trial 0, episode 3 of 3: ") and "3 of 9 in all" in said[4]
    assert said[5:] == [f"wrote {tasks[0].path}"]


def test_partial_line_of_a_journal_is_reported_once_complete(
    tasks: list[LearningTask], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    take(tmp_path / "policy.yaml", EPISODES)
    whole = trial_journal(tmp_path / "policy.yaml").read_bytes()
    watching = supervision(tasks)
    told = []
    for size in (0, 10, len(whole) // 2, len(whole) - 1, len(whole)):
        tasks[1].journal.write_bytes(whole[:size])
        watching.look(1)
        told.append(capsys.readouterr().out.count("episode "))
    assert told[-1] and told[-2] == 0 == told[0]


def test_failed_trials_are_reported_immediately_and_with_reasons_at_the_end(
    tasks: list[LearningTask], capsys: pytest.CaptureFixture[str]
) -> None:
    watching = supervision(tasks)
    watching.conclude()
    watching.failed(tasks[0], UsageError("its worker is ill"))
    watching.failed(tasks[1], OSError(28, "No space left on device"))
    watching.failed(tasks[2], UsageError("its worker is ill"))
    assert capsys.readouterr().out.splitlines()[0] == "trial 0 cannot go on: its worker is ill"
    with pytest.raises(UsageError, match=r"trial 0, 2: .* ill; trial 1: .*_1.yaml: No space"):
        watching.conclude()
