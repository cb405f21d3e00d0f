"""Peers of the benchmarks: one that is missing is reported with the reason."""

from __future__ import annotations

import json
import subprocess
import sys

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


def test_a_peers_process_says_why_it_has_none() -> None:
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
def test_a_missing_peer_has_a_reason(python: str, reason: str) -> None:
    run = subprocess.run(
        [sys.executable, "-c", ASK, python], cwd=FOLDER, capture_output=True, text=True
    )
    assert run.stdout.strip() == reason
