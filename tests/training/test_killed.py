"""``cb learn`` killed again and again: nothing is lost, and the end is that of an unbroken run."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.training.tasks import outcome
from tests.training.test_trial_work import without_seconds

EPISODES = 14
JOURNAL = "policy.episodes.jsonl"
LEARN = [
    *("learn", "searchtrack", "--stage", "searchtrack_training", "--backend", "kinematic"),
    *("--seed", "3", "--episodes", str(EPISODES), "--out", "policy.yaml"),
]
ASSIMILATE = [
    *("learn", "reachtouch", "--learner", "assimilate", "--from", "reachtouch"),
    *("--stage", "near_and_far_training", "--backend", "kinematic", "--idle-time", "1"),
    *LEARN[-6:],
]
#: Command for a schema in which some allocations bring other programs.
EXCHANGE = [
    *("learn", "pick_and_place", "--learner", "assimilate", "--from", "pick_and_place"),
    *("--stage", "things_and_far_pads", "--backend", "kinematic", "--idle-time", "1"),
    *("--set", "blames_first=True", "--transition-time", "20", "--episode-time", "40"),
    *("--seed", "3", "--episodes", "6", "--out", "policy.yaml"),
]

AS_EVER = ("-c", "from cbdsl.cli.main import main; main()")
ON_A_SLOW_DISK = ("-m", "tests.training.slow_disk")


def cb(
    folder: Path, how: tuple[str, str], *words: str, learn: list[str] = LEARN
) -> subprocess.Popen[bytes]:
    """Start ``cb learn`` in a folder."""
    return subprocess.Popen(
        [sys.executable, *how, *learn, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
    )


def lines(folder: Path, name: str = JOURNAL) -> int:
    """Return the number of complete lines in the journal."""
    journal = folder / name
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


def killed(folder: Path, more: int, later: float, learn: list[str]) -> bool:
    """Start or resume the run in a folder, and kill it.

    Args:
        folder: Folder of the run.
        more: Number of further lines in its journal to wait for, or for a document's write.
        later: Time to wait after that, s.
        learn: Words of the command.

    Returns:
        True if it was killed before it came to its end.
    """
    wanted, before = lines(folder) + more, set(folder.iterdir())
    process = cb(folder, ON_A_SLOW_DISK, "--resume", learn=learn)
    while process.poll() is None and lines(folder) < wanted:
        if any(file.name.startswith(".") for file in set(folder.iterdir()) - before):
            break
        time.sleep(0.002)
    time.sleep(later)
    process.kill()
    return process.wait() == -signal.SIGKILL


@pytest.mark.slow
@pytest.mark.parametrize(
    ("learn", "often"),
    [(LEARN, 12), (ASSIMILATE, 8), (EXCHANGE, 4)],
    ids=["accommodate", "assimilate", "exchange"],
)
def test_repeatedly_killed_trial_ends_with_the_same_documents(
    tmp_path: Path, learn: list[str], often: int
) -> None:
    unbroken, broken = tmp_path / "unbroken", tmp_path / "broken"
    unbroken.mkdir()
    broken.mkdir()
    began = time.monotonic()
    assert cb(unbroken, AS_EVER, learn=learn).wait() == 0
    pace = (time.monotonic() - began) / lines(unbroken)
    expected, rng, kills = outcome(unbroken), np.random.default_rng(7), 0
    while kills < often:
        before = lines(broken)
        more, later = int(rng.integers(0, 3)), pace * rng.random()
        kills += killed(broken, more, later, learn)
        assert lines(broken) >= before
        assert outcome(broken).items() <= expected.items()
    assert cb(broken, AS_EVER, "--resume", learn=learn).wait() == 0
    assert outcome(broken) == expected
    assert without_seconds(broken / JOURNAL) == without_seconds(unbroken / JOURNAL)
    assert {file.name for file in broken.iterdir()} == {file.name for file in unbroken.iterdir()}


def is_free(journal: Path) -> bool:
    """Return True if no process works on it."""
    with journal.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


@pytest.mark.slow
def test_trial_killed_with_its_workers_resumes_without_them(tmp_path: Path) -> None:
    trials = [f"policy_{number}.episodes.jsonl" for number in range(2)]
    unbroken, broken = tmp_path / "unbroken", tmp_path / "broken"
    unbroken.mkdir()
    broken.mkdir()
    assert cb(unbroken, AS_EVER, "--trials", "2").wait() == 0
    endless = ("--trials", "2", "--workers", "2", "--episodes", "1000000")
    command = cb(broken, AS_EVER, *endless)
    while command.poll() is None and not any(lines(broken, each) > 2 for each in trials):
        time.sleep(0.01)
    command.kill()
    assert command.wait() == -signal.SIGKILL
    # Workers end with the command that started them; until then they hold their journals.
    while not all(is_free(file) for file in broken.glob("*.jsonl")):
        time.sleep(0.01)
    assert cb(broken, AS_EVER, "--trials", "2", "--resume").wait() == 0
    assert outcome(broken) == outcome(unbroken)
