"""Compare the control tick with that of another checkout, in one interleaved run."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
CASES = ("two arms", "Dexter", "two arms, the right one stretched")
QUANTILES = (0.1, 0.25, 0.5)
#: Runs in a checkout of its own: times each tick of all cases, us, once a line of input.
_TIMER = """
import json, sys, time
import numpy as np
sys.path[:0] = [sys.argv[1], sys.argv[1] + "/benchmarks"]
from control_peers import two_arms
from ours import DexterCycle, TwoArms
with two_arms() as folder:
    arms, cycle = TwoArms(folder, 1 / 60), DexterCycle.of("reachtouch")
    cycle.restart()
    around = arms.ready + np.random.default_rng(0).uniform(-0.3, 0.3, (60, 14))
    postures = np.clip(around, arms.lower + 0.05, arms.upper - 0.05)
    stretched = np.copy(arms.ready)
    stretched[7:] = 0.1351, -1.5781, 0.5475, 0.2305, -3.1416, 0.1489, -1.4659
    singular = stretched + np.random.default_rng(1).uniform(-0.01, 0.01, (60, 14))
    cases = (
        (arms.tick, np.copy, postures),
        (cycle.tick, lambda posture: cycle.following(), postures),
        (arms.tick, np.copy, singular),
    )
    for _ in sys.stdin:
        times = [[] for _ in cases]
        for (tick, prepare, each), found in zip(cases, times):
            for posture in each:
                given, began = prepare(posture), time.perf_counter()
                tick(given)
                found.append((time.perf_counter() - began) * 1e6)
        print(json.dumps(times), flush=True)
"""


def start(folder: Path) -> subprocess.Popen[str]:
    """Start the timer of a checkout, and let it compile."""
    command = [sys.executable, "-c", _TIMER, str(folder)]
    place = folder / "benchmarks"
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, cwd=place, stdin=pipe, stdout=pipe, text=True)
    measure(process)
    return process


def measure(process: subprocess.Popen[str]) -> list[list[float]]:
    """Return the times of the ticks of all cases, us."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("\n")
    process.stdin.flush()
    found: list[list[float]] = json.loads(process.stdout.readline())
    return found


def main() -> None:
    """Print quantiles of both checkouts and their ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="checkout to compare with")
    parser.add_argument("--rounds", type=int, default=60, help="rounds, each in turn")
    given = parser.parse_args()
    processes = [start(given.folder.resolve()), start(ROOT)]
    rounds = [[measure(process) for process in processes] for _ in range(given.rounds)]
    times = np.array(rounds)  # rounds, checkouts, cases, ticks
    for number, name in enumerate(CASES):
        # Low quantiles are the least disturbed by other work on the machine.
        old, new = (np.quantile(times[:, which, number], QUANTILES) for which in (0, 1))
        print(f"{name}: {old.round(1)} us before, {new.round(1)} us now, {(new / old).round(2)} x")
    for process in processes:
        process.kill()


if __name__ == "__main__":
    main()
