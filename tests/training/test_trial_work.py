"""A trial ends the same however often it is killed, and nothing that was run is lost."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.learning.experience import EPISODES as ROWS
from cbdsl.storage.journal import Journal, JournalError
from cbdsl.storage.journal_follower import JournalFollower
from cbdsl.training.task_files import trial_journal
from cbdsl.yaml_text.library import Library
from tests.training.toy import (
    EPISODES,
    ROOT,
    ToyEpisodeRunner,
    take,
    take_and_die,
    toy_trial,
)

FILES = ("policy.yaml", "policy_head.yaml")


def texts(folder: Path) -> list[bytes]:
    return [(folder / name).read_bytes() for name in FILES]


def without_seconds(journal: Path) -> list[str]:
    """Return its lines without the only entry that depends on the machine."""
    return [line.partition(', "wall_seconds"')[0] for line in journal.read_text().splitlines()]


def test_learned_documents_have_no_diagnostics(unbroken: Path) -> None:
    for name in FILES:
        assert check_document(unbroken / name, session=Session(Library(ROOT))) == []


def test_another_seed_is_another_outcome(unbroken: Path, tmp_path: Path) -> None:
    take(tmp_path / "policy.yaml", EPISODES, seed=2)
    assert texts(tmp_path) != texts(unbroken)


def test_trial_killed_at_any_point_ends_with_the_same_documents(
    unbroken: Path, tmp_path: Path
) -> None:
    # While an episode runs, after its line is written, before a document takes its place.
    hold, fsync, replace = (ToyEpisodeRunner, "run"), (os, "fsync"), (os, "replace")
    points = ((hold, 3), (fsync, 1), (fsync, 4), (hold, 2), (fsync, 2), (replace, 1), (replace, 2))
    for (owner, name), count in points:
        given = (tmp_path / "policy.yaml", EPISODES, owner, name, count)
        killed = multiprocessing.get_context("fork").Process(target=take_and_die, args=given)
        killed.start()
        killed.join()
        assert killed.exitcode == -signal.SIGKILL
        assert not (tmp_path / "policy.yaml").exists()
    take(tmp_path / "policy.yaml", EPISODES, resume=True)
    assert texts(tmp_path) == texts(unbroken)
    journals = (trial_journal(folder / "policy.yaml") for folder in (tmp_path, unbroken))
    assert without_seconds(next(journals)) == without_seconds(next(journals))


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.333, 0.5, 0.77, 0.999])
def test_torn_line_counts_for_nothing(unbroken: Path, tmp_path: Path, share: float) -> None:
    whole = trial_journal(unbroken / "policy.yaml").read_bytes()
    trial_journal(tmp_path / "policy.yaml").write_bytes(whole[: int(share * len(whole))])
    take(tmp_path / "policy.yaml", EPISODES, resume=True)
    assert texts(tmp_path) == texts(unbroken)


def test_trial_can_be_made_longer_and_shorter(unbroken: Path, tmp_path: Path) -> None:
    take(tmp_path / "policy.yaml", 5)
    take(tmp_path / "policy.yaml", EPISODES + 3, resume=True)
    assert texts(tmp_path) != texts(unbroken)
    take(tmp_path / "policy.yaml", EPISODES, resume=True)
    assert texts(tmp_path) == texts(unbroken)


def test_existing_documents_are_not_overwritten(unbroken: Path, tmp_path: Path) -> None:
    before = texts(unbroken)
    with pytest.raises(JournalError, match="--resume"):
        take(unbroken / "policy.yaml", EPISODES)
    foreign = tmp_path / "policy.yaml"
    foreign.write_text("not learned", encoding="utf-8")
    with pytest.raises(JournalError, match="not learned here"):
        take(foreign, EPISODES, resume=True)
    assert texts(unbroken) == before and foreign.read_text("utf-8") == "not learned"


def test_another_trial_does_not_go_on_with_this_one(tmp_path: Path) -> None:
    take(tmp_path / "policy.yaml", 3)
    with pytest.raises(JournalError, match="seed was 1, is 2"):
        take(tmp_path / "policy.yaml", 5, resume=True, seed=2)


def test_full_disk_keeps_finished_episodes_and_no_partial_document(
    unbroken: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = 0

    def full(handle: int) -> None:
        nonlocal written
        written += 1
        if written > 5:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="No space"):
            take(tmp_path / "policy.yaml", EPISODES)
    assert [path.name for path in tmp_path.iterdir()] == ["policy.episodes.jsonl"]
    take(tmp_path / "policy.yaml", EPISODES, resume=True)
    assert texts(tmp_path) == texts(unbroken)


@pytest.mark.parametrize("text", ["no json\n", "[1]\n", '{"seed": 1}\n'])
def test_file_that_is_no_journal_is_left_alone(tmp_path: Path, text: str) -> None:
    journal = trial_journal(tmp_path / "policy.yaml")
    journal.write_text(text, encoding="utf-8")
    with pytest.raises(JournalError, match=r"policy\.episodes\.jsonl"):
        take(tmp_path / "policy.yaml", 3, resume=True)
    assert journal.read_text("utf-8") == text


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda line: line.replace('"seed"', '"sead"'), "it lacks 'seed'"),
        (lambda line: line[:-20], "it is not JSON ("),
        (lambda line: "[1, 2]", "it is not a JSON object"),
        (
            lambda line: line.replace('"rewarded": {', '"rewarded": 7, "r": {'),
            "it is not an episode (",
        ),
    ],
)
def test_damaged_line_is_reported_by_its_number_and_how_to_go_on(
    damage: Callable[[str], str], problem: str, tmp_path: Path
) -> None:
    path = tmp_path / "policy.episodes.jsonl"
    trial, runner = toy_trial(), ToyEpisodeRunner()
    with Journal(path, {"trial": 1}, ROWS) as journal:
        for _ in range(3):
            journal.append(trial.run(runner))
    lines = path.read_text("utf-8").splitlines()
    lines[2] = damage(lines[2])
    path.write_text("\n".join(lines) + "\n", "utf-8")
    followed = JournalFollower(path, ROWS)
    for read in (lambda: Journal(path, {"trial": 1}, ROWS), followed.poll):
        with pytest.raises(JournalError) as caught:
            read()
        told = str(caught.value)
        assert told.startswith(f"{path}, line 3: {problem}") and "--resume" in told
    path.write_text("\n".join(lines[:2]) + "\n", "utf-8")  # as the message says
    with Journal(path, {"trial": 1}, ROWS) as journal:
        assert len(journal.rows) == 1
