"""Trials of ``cb learn`` in one process and in two workers: how much sooner they are over.

Both learn the same, turn by turn, each time from zero and with all that it takes: start-up, the
cluster, the documents. For each it prints wall-clock and processor seconds, and processor seconds
per trial: what two workers spend more is what side by side costs, however busy the machine is.
The ratio is that of the wall-clock seconds, round by round and their median. It fails where the
documents differ. Run with ``python benchmarks/parallel_trials.py``, on an idle machine of two
processors or more.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

CB = [sys.executable, "-c", "from cbdsl.cli.main import main; main()"]


@dataclass(frozen=True)
class Measurement:
    """What one run of ``cb learn`` took.

    Attributes:
        wall: seconds that passed.
        user: processor seconds in its processes, all together.
        system: processor seconds in the kernel for them.
    """

    wall: float
    user: float
    system: float


def learn(folder: Path, workers: int, options: argparse.Namespace) -> Measurement:
    """Run ``cb learn`` in a folder."""
    folder.mkdir(parents=True)
    words = [
        *("learn", options.program, "--stage", options.stage, "--backend", options.backend),
        *("--trials", str(options.trials), "--episodes", str(options.episodes)),
        *("--workers", str(workers), "--out", "policy.yaml"),
    ]
    began = time.perf_counter()
    process = subprocess.Popen([*CB, *words], cwd=folder, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)  # with the workers, which it waited for
    wall = time.perf_counter() - began
    if status:
        sys.exit(f"cb learn --workers {workers} failed")
    return Measurement(wall, usage.ru_utime, usage.ru_stime)


def documents(folder: Path) -> dict[str, bytes]:
    """What was learned."""
    return {file.name: file.read_bytes() for file in folder.glob("*.yaml")}


def measured(options: argparse.Namespace) -> dict[int, list[Measurement]]:
    """Measurements by number of workers, in the order of the rounds."""
    found: dict[int, list[Measurement]] = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as place:
        learn(Path(place) / "compiled", 1, options)  # and files that are read are in memory
        for turn in range(options.rounds):
            folders = {workers: Path(place) / f"{turn}_{workers}" for workers in found}
            for workers, folder in folders.items():
                found[workers].append(learn(folder, workers, options))
            if documents(folders[1]) != documents(folders[2]):
                sys.exit("two workers learned something else than one process")
    return found


def summary(found: dict[int, list[Measurement]], trials: int) -> dict[str, object]:
    """Medians by number of workers, and ratios."""
    ratios = [one.wall / two.wall for one, two in zip(found[1], found[2], strict=True)]
    rows = {
        f"workers_{workers}": {
            "wall": round(statistics.median(each.wall for each in runs), 2),
            "user": round(statistics.median(each.user for each in runs), 2),
            "system": round(statistics.median(each.system for each in runs), 2),
            "user_per_trial": round(statistics.median(each.user for each in runs) / trials, 3),
        }
        for workers, runs in found.items()
    }
    ratio = {"ratio": round(statistics.median(ratios), 3), "ratios": [round(r, 3) for r in ratios]}
    return {**rows, **ratio}


def main() -> None:
    """Measure and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="searchtrack")
    parser.add_argument("--stage", default="searchtrack_training")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--trials", type=int, default=16)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    print(json.dumps(summary(measured(options), options.trials), indent=2))


if __name__ == "__main__":
    main()
