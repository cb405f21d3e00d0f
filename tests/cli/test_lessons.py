"""What is told of trials that run elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from cbdsl.cli.learning_progress import LearningProgress
from cbdsl.cli.lessons import Supervision
from cbdsl.errors.errors import UsageError
from cbdsl.training.assignment import Assignment
from cbdsl.training.course import journal_file
from tests.training.lessons import assigned
from tests.training.toy import take

EPISODES = 3


@pytest.fixture
def assignments(tmp_path: Path) -> list[Assignment]:
    return assigned(tmp_path, 3, EPISODES)


def supervision(assignments: Sequence[Assignment]) -> Supervision:
    progress = LearningProgress("searchtrack", len(assignments), EPISODES)
    return Supervision(assignments, progress)


def test_episodes_are_told_as_they_end_elsewhere_and_before_their_files(
    assignments: list[Assignment], capsys: pytest.CaptureFixture[str]
) -> None:
    take(assignments[0].path, EPISODES - 1)
    watching = supervision(assignments)
    watching.look(0)
    watching.look(2)
    take(assignments[0].path, EPISODES, resume=True)
    watching.done(assignments[0], [assignments[0].path])
    said = capsys.readouterr().out.splitlines()
    assert said[1] == "trial 0: 2 of 3 episodes are over"
    assert said[2:4] == ["no workers: waiting for some", "workers: 2"]
    assert said[4].startswith("trial 0, episode 3 of 3: ") and "3 of 9 in all" in said[4]
    assert said[5:] == [f"wrote {assignments[0].path}"]


def test_a_torn_line_is_told_when_it_is_whole(
    assignments: list[Assignment], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    take(tmp_path / "policy.yaml", EPISODES)
    whole = journal_file(tmp_path / "policy.yaml").read_bytes()
    watching = supervision(assignments)
    told = []
    for size in (0, 10, len(whole) // 2, len(whole) - 1, len(whole)):
        assignments[1].journal.write_bytes(whole[:size])
        watching.look(1)
        told.append(capsys.readouterr().out.count("episode "))
    assert told[-1] and told[-2] == 0 == told[0]


def test_failures_are_told_at_once_and_with_their_reasons_at_the_end(
    assignments: list[Assignment], capsys: pytest.CaptureFixture[str]
) -> None:
    watching = supervision(assignments)
    watching.conclude()
    watching.failed(assignments[0], UsageError("its worker is ill"))
    watching.failed(assignments[1], OSError(28, "No space left on device"))
    watching.failed(assignments[2], UsageError("its worker is ill"))
    assert capsys.readouterr().out.splitlines()[0] == "trial 0 cannot go on: its worker is ill"
    with pytest.raises(UsageError, match=r"trial 0, 2: .* ill; trial 1: .*_1.yaml: No space"):
        watching.conclude()
