"""``cb run --workers``: the results of one process, and outputs that it refuses."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from typing import Any

import pytest

from tests.cli.test_main import cb
from tests.conftest import ROOT

RUN = ("run", "reachtouch", "--backend", "kinematic")
CB = (sys.executable, "-c", "from cbdsl.cli.main import main; main()")


# Time for the end of all processes, s.
PATIENCE = 30.0


def rows(text: str) -> list[dict[str, Any]]:
    """Return the results without the time that depends on the machine."""
    return [{**json.loads(line), "wall_seconds": 0} for line in text.splitlines()]


@pytest.mark.parametrize(
    "words",
    [
        ["--explain"],
        ["--page", "x.html"],
        ["--record", "x"],
        ["--watch"],
        ["--live"],
        ["--yes"],
        ["--interface", "lo"],
    ],
)
def test_workers_refuse_outputs_of_one_process(
    words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *RUN, "--workers", "2", *words) == 2
    assert f"{words[0]} is for episodes of one process" in capsys.readouterr().err


def test_workers_beyond_the_processors_are_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *RUN, "--workers", "5000", "--episodes", "5000") == 2
    assert "--workers 5000: at most " in capsys.readouterr().err


def test_workers_refuse_a_real_robot(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("cyclonedds")
    assert cb(monkeypatch, *RUN[:2], "--backend", "ros2", "--workers", "2") == 2
    assert "--workers is for simulators" in capsys.readouterr().err


def test_workers_refuse_a_world_that_goes_on_between_episodes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stage = ("--stage", "exploring_basketball")
    assert cb(monkeypatch, *RUN, *stage, "--workers", "2") == 2
    assert "goes on between episodes: leave out --workers" in capsys.readouterr().err


def test_summary_counts_the_episodes_of_workers(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # One episode needs no other process.
    assert cb(monkeypatch, *RUN, "--workers", "2") == 0
    told = capsys.readouterr().out
    assert told.startswith("  Rewarded after ") and "1 of 1 episodes rewarded" in told


@pytest.mark.slow
def test_workers_return_the_results_of_one_process(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    results = []
    for workers in ("1", "2"):
        assert cb(monkeypatch, *RUN, "--episodes", "3", "--json", "--workers", workers) == 0
        results.append(rows(capfd.readouterr().out))
    assert len(results[0]) == 3 and results[0] == results[1]


@pytest.mark.slow
def test_interrupt_of_a_terminal_ends_all_workers_without_a_traceback() -> None:
    command = [*CB, *RUN, "--episodes", "10000", "--workers", "2"]
    process = subprocess.Popen(
        command, cwd=ROOT, start_new_session=True, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline().startswith("  Rewarded")
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "Traceback" not in errors
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and runs(process.pid):
        time.sleep(0.1)
    assert not runs(process.pid)


def runs(group: int) -> bool:
    """Return whether any process of a group runs."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
