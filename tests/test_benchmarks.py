"""Benchmarks: a missing peer is reported with the reason, and a missed target fails."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

from tests.conftest import ROOT

FOLDER = ROOT / "benchmarks"
SCENE = json.dumps({"urdf": "none.urdf", "ready": [0.0]})
ASK = """
import sys
from pathlib import Path
import numpy
from peer_process import remote_peers
from peers import Scene
scene = Scene(Path("none.urdf"), numpy.zeros(1))
try:
    with remote_peers("nonesuch", sys.argv[1], scene):
        print("here")
except ImportError as error:
    print(error)
"""


def test_process_of_a_missing_peer_states_the_reason() -> None:
    run = subprocess.run(
        [sys.executable, str(FOLDER / "peer_process.py"), "nonesuch"],
        input=f"{SCENE}\n", capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert json.loads(run.stdout) == {"missing": "No module named 'nonesuch'"}


@pytest.mark.parametrize(
    ("python", "reason"),
    [
        (sys.executable, "No module named 'nonesuch'"),
        ("/nonesuch/python", "/nonesuch/python: No such file or directory"),
        ("/bin/true", "its process has ended with code 0"),
    ],
)
def test_missing_peer_has_a_reason(python: str, reason: str) -> None:
    run = subprocess.run(
        [sys.executable, "-c", ASK, python], cwd=FOLDER, capture_output=True, text=True
    )
    assert run.stdout.strip() == reason


def _benchmark(name: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(FOLDER))
    return importlib.import_module(name)


def _status(main: Callable[[], Any]) -> int:
    try:
        return int(main() or 0)
    except SystemExit as ended:
        return int(ended.code or 0)


def test_benchmark_takes_a_seed_and_a_number_of_episodes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["episode_speed", "--help"])
    assert _status(_benchmark("episode_speed", monkeypatch).main) == 0
    told = capsys.readouterr().out
    assert all(option in told for option in ("--seed ", "--episodes ", "--json"))


def test_speed_targets_are_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    speed = _benchmark("episode_speed", monkeypatch)
    summary = {"simulated_per_wall": 4.1, "percent": {"perception": 11.9}}
    assert not speed.misses(speed.BODIES[0], summary)
    assert speed.misses(speed.BODIES[0], summary | {"simulated_per_wall": 3.9})
    assert speed.misses(speed.BODIES[0], summary | {"percent": {"perception": 12.1}})


@pytest.mark.parametrize(
    ("episodes", "first"),
    [("11011", 1), ("0011101", 3), ("010101011011", 8), ("1110", None), ("", None)],
)
def test_skill_learned_at_start_of_good_window(
    episodes: str, first: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot_transfer = _benchmark("robot_transfer", monkeypatch)
    assert robot_transfer.first_of_good([each == "1" for each in episodes]) == first
