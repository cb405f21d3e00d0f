"""Duration of trials of ``cb learn`` in one process and in two workers.

Both learn the same, in turn, each time from scratch and including start-up, cluster and documents.
Each row has wall-clock and processor seconds, and processor seconds per trial; the difference of
the latter is the cost of the second worker, regardless of other work on the machine. The ratio is
that of the wall-clock seconds, by round and as a median. The bound is the ratio of two unrelated
processes: half of the trials in one process, alone and beside another process that does the same.
The benchmark fails if the documents differ. It takes about four minutes on an idle machine of two
processors or more. More rounds reduce the uncertainty.

    python benchmarks/parallel_trials.py
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
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

CB = [sys.executable, "-c", "from cbdsl.cli.main import main; main()"]


@dataclass(frozen=True)
class Measurement:
    """The time of one run of ``cb learn``, or of several at the same time.

    Attributes:
        wall: Wall-clock time, s.
        user: Processor time in all its processes together, s.
        system: Processor time in the kernel for them, s.
    """

    wall: float
    user: float
    system: float


@dataclass(frozen=True)
class Round:
    """Times of one turn: all trials in one process and in two, half of them alone and in pairs."""

    one: Measurement
    two: Measurement
    alone: Measurement
    paired: Measurement

    @property
    def ratio(self) -> float:
        """How much sooner two workers are over."""
        return self.one.wall / self.two.wall

    @property
    def bound(self) -> float:
        """How much two processes do in the time of one."""
        return 2 * self.alone.wall / self.paired.wall


def learn(
    folders: Sequence[Path], workers: int, trials: int, episodes: int, options: argparse.Namespace
) -> Measurement:
    """Run ``cb learn`` in each folder at the same time; the longest of them and the sum of all."""
    words = [
        *("learn", options.program, "--stage", options.stage, "--backend", options.backend),
        *("--trials", str(trials), "--episodes", str(episodes)),
        *("--workers", str(workers), "--out", "policy.yaml"),
    ]
    for folder in folders:
        folder.mkdir(parents=True)
    began = time.perf_counter()
    processes = [
        subprocess.Popen([*CB, *words], cwd=folder, stdout=subprocess.DEVNULL) for folder in folders
    ]
    ends = [os.wait4(each.pid, 0) for each in processes]  # with the workers, which it waited for
    wall = time.perf_counter() - began
    if any(status for _, status, _ in ends):
        sys.exit(f"cb learn --workers {workers} failed")
    user, system = (sum(getattr(u, name) for _, _, u in ends) for name in ("ru_utime", "ru_stime"))
    return Measurement(wall, user, system)


def documents(folder: Path) -> dict[str, bytes]:
    """Return the learned policies, file by file."""
    return {file.name: file.read_bytes() for file in folder.glob("*.yaml")}


def measured(options: argparse.Namespace) -> list[Round]:
    """Return all rounds."""
    with tempfile.TemporaryDirectory() as place:
        # This run compiles, and brings files into memory.
        learn([Path(place) / "compiled"], 1, 1, 1, options)
        return [turn(Path(place) / str(number), options) for number in range(options.rounds)]


def turn(place: Path, options: argparse.Namespace) -> Round:
    """Run one round, in a folder of its own."""
    trials, episodes = options.trials, options.episodes
    one = learn([place / "one"], 1, trials, episodes, options)
    two = learn([place / "two"], 2, trials, episodes, options)
    if documents(place / "one") != documents(place / "two"):
        sys.exit("two workers learned something else than one process")
    # Two unrelated processes share the work without a cluster, which bounds the gain of two
    # workers.
    alone = learn([place / "alone"], 1, trials // 2, episodes, options)
    pair = [place / "left", place / "right"]
    return Round(one, two, alone, learn(pair, 1, trials // 2, episodes, options))


def summary(rounds: Sequence[Round], trials: int) -> dict[str, object]:
    """Return medians by number of workers, ratios, and the bound."""
    runs = {"workers_1": [each.one for each in rounds], "workers_2": [each.two for each in rounds]}
    ratios, bounds = [each.ratio for each in rounds], [each.bound for each in rounds]
    return {
        **{name: row(each, trials) for name, each in runs.items()},
        "ratio": round(statistics.median(ratios), 3),
        "ratios": [round(ratio, 3) for ratio in ratios],
        "bound": round(statistics.median(bounds), 3),
        "bounds": [round(bound, 3) for bound in bounds],
    }


def row(runs: Sequence[Measurement], trials: int) -> dict[str, float]:
    """Return medians of the measurements."""
    user = statistics.median(each.user for each in runs)
    return {
        "wall": round(statistics.median(each.wall for each in runs), 2),
        "user": round(user, 2),
        "system": round(statistics.median(each.system for each in runs), 2),
        "user_per_trial": round(user / trials, 3),
    }


def main() -> None:
    """Measure and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="searchtrack")
    parser.add_argument("--stage", default="searchtrack_training")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--trials", type=int, default=16)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=1)
    options = parser.parse_args()
    print(json.dumps(summary(measured(options), options.trials), indent=2))


if __name__ == "__main__":
    main()
