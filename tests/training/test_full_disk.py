"""Full disks: reported, nothing half written, and a resumed trial ends as if uninterrupted."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cbdsl.training import task_files
from cbdsl.training.task_files import trial_journal
from tests.conftest import ROOT
from tests.full_disk import no_file_beyond
from tests.training.tasks import outcome
from tests.training.toy import EPISODES, take


def test_disk_without_room_is_reported_before_the_episodes(tmp_path: Path) -> None:
    with no_file_beyond(1000), pytest.raises(OSError, match="too large"):
        take(tmp_path / "policy.yaml", EPISODES)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("share", [0.01, 0.2, 0.5, 0.8, 0.99])
def test_disk_that_fills_up_while_episodes_run_costs_one(
    unbroken: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    whole = trial_journal(unbroken / "policy.yaml").read_bytes()
    size = int(share * len(whole))
    with monkeypatch.context() as patch, no_file_beyond(size):
        patch.setattr(task_files, "_ROOM", 0)  # it was there at the beginning
        with pytest.raises(OSError, match="too large"):
            take(tmp_path / "policy.yaml", EPISODES)
    assert outcome(tmp_path) == {}
    journal = trial_journal(tmp_path / "policy.yaml")
    if journal.exists():
        assert journal.read_bytes().count(b"\n") >= whole[:size].count(b"\n") - 1
    take(tmp_path / "policy.yaml", EPISODES, resume=True)
    assert outcome(tmp_path) == outcome(unbroken)


LEARN = (
    "learn searchtrack --stage searchtrack_training --backend kinematic --seed 3 --episodes 60 "
    "--out policy.yaml"
)
CB = [sys.executable, "-c", "from cbdsl.cli.main import main; main()"]
SMALL_DISK = f"""
mount -t tmpfs -o size=72k tmpfs disk || exit 99
cd disk
"$@" {LEARN} 2> ../said
echo $? > ../code
ls -A > ../left
mount -o remount,size=16m . && "$@" {LEARN} --resume && cp policy*.yaml ..
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("unshare") is None, reason="no disk of its own without unshare")
def test_small_disk_is_reported_and_with_a_larger_one_the_run_goes_on(tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "unbroken").mkdir()
    small = ["unshare", "--map-root-user", "--mount", "sh", "-c", SMALL_DISK, "sh", *CB]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    code = subprocess.run(small, cwd=tmp_path, env=environment).returncode
    if code in (1, 99):
        pytest.skip("nothing may be mounted here")
    assert code == 0
    assert (tmp_path / "code").read_text("utf-8") == "2\n"
    said = (tmp_path / "said").read_text("utf-8")
    assert "No space left on device" in said and "--resume continues" in said
    assert (tmp_path / "left").read_text("utf-8") == "policy.episodes.jsonl\n"
    again = [*CB, *LEARN.split()]
    subprocess.run(again, cwd=tmp_path / "unbroken", env=environment, check=True)
    assert outcome(tmp_path) == outcome(tmp_path / "unbroken")
