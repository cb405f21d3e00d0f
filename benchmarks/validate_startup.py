"""``cb validate robots programs`` against the start-up that its libraries need anyway.

Whole processes, from start to exit, turn by turn: one validates everything that is shipped, the
other only imports pydantic, PyYAML and Lark, a third is Python alone. Run with
``python benchmarks/validate_startup.py``.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).parents[1]
VALIDATE = "from cbdsl.cli.main import main; main()"
COMMANDS = {
    "validate": [sys.executable, "-c", VALIDATE, "validate", "robots", "programs"],
    "imports": [sys.executable, "-c", "import lark, pydantic, yaml"],
    "python": [sys.executable, "-c", ""],
}


def seconds(command: list[str]) -> float:
    """Wall-clock time of a process.

    Raises:
        CalledProcessError: it failed.
    """
    start = perf_counter()
    subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    return perf_counter() - start


def main() -> None:
    """Time the processes and print medians and the ratio of the first two."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    times: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for _ in range(options.rounds):
        for name, command in COMMANDS.items():
            times[name].append(seconds(command))
    medians = {name: round(statistics.median(values), 3) for name, values in times.items()}
    ratio = round(medians["validate"] / medians["imports"], 2)
    if options.json:
        sys.stdout.write(json.dumps({"seconds": medians, "ratio": ratio}) + "\n")
        return
    for name, median in medians.items():
        sys.stdout.write(f"{name:10}{median * 1e3:6.0f} ms\n")
    sys.stdout.write(f"validate / imports {ratio:.2f}\n")


if __name__ == "__main__":
    main()
