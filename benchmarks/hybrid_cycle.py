"""Control cycle of a hybrid stack of six levels, against that of another checkout.

This checkout runs ``hybrid.yaml`` beside this file: force along one axis and position along the
others, below guards, with a posture, fingers and the head. The other checkout runs the cycle of
``control_cycle.py``, six levels of force and position in ``reach ◁ touch``; this one runs it too,
for comparison. Checkouts take turns in processes of their own, with this interpreter, and times are
medians. The exit status is 1 if the median ratio to the other checkout's cycle is above 1.

    git worktree add ../before 9a0a0bf
    python benchmarks/hybrid_cycle.py --against ../before [--rounds 5] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

from control_cycle import whole
from ours import DexterCycle

HERE = Path(__file__).parents[1]


def measured(folder: Path, script: Path, *options: str) -> tuple[str, float]:
    """Return the action and the median of whole cycles, us, by a benchmark of a checkout."""
    command = [sys.executable, str(script), "--json", *options]
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    row = json.loads(done.stdout.splitlines()[-1])
    return row["action"], float(row["microseconds"]["cycle"])


def hybrid(restarts: int) -> dict[str, object]:
    """Measure the hybrid cycle, in this process."""
    cycle = DexterCycle.of(str(Path(__file__).parent / "hybrid.yaml"))
    times = whole(cycle, restarts)
    return {
        "action": cycle.action,
        "microseconds": {"cycle": round(statistics.median(times), 1)},
    }


def main() -> int:
    """Run rounds in turn and print medians; 1 where the hybrid cycle is slower."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--against", type=Path, metavar="DIR", help="another checkout")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--restarts", type=int, default=20, help="series of cycles in a round")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    restarts = ("--restarts", str(options.restarts))
    if options.against is None:
        sys.stdout.write(json.dumps(hybrid(options.restarts)) + "\n")
        return 0
    against = options.against.resolve()
    runs = {
        "hybrid": (HERE, Path(__file__)),
        "reach ◁ touch": (HERE, HERE / "benchmarks/control_cycle.py"),
        "against": (against, against / "benchmarks/control_cycle.py"),
    }
    times: dict[str, list[float]] = {name: [] for name in runs}
    actions = {name: measured(*run, *restarts)[0] for name, run in runs.items()}  # compiles, too
    for number in range(options.rounds):
        # The alternating order cancels a trend of the machine's speed within a round.
        for name in list(runs)[:: 1 if number % 2 == 0 else -1]:
            times[name].append(measured(*runs[name], *restarts)[1])
    pairs = zip(times["hybrid"], times["against"], strict=True)
    ratio = statistics.median(ours / theirs for ours, theirs in pairs)
    medians = {name: round(statistics.median(each), 1) for name, each in times.items()}
    if options.json:
        sys.stdout.write(
            json.dumps({"actions": actions, "microseconds": medians, "ratio": round(ratio, 3)})
        )
        sys.stdout.write("\n")
    else:
        for name, time in medians.items():
            sys.stdout.write(f"{name:14} {time:6.1f} us  {actions[name]}\n")
        sys.stdout.write(f"hybrid / against: {ratio:.2f}\n")
    return int(ratio > 1.0)


if __name__ == "__main__":
    sys.exit(main())
