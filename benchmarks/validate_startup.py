"""Time of ``cb validate robots programs`` against the start-up of its libraries.

Whole processes run in turn, from start to exit. One validates all shipped documents, and one only
imports pydantic and PyYAML. One also makes a pydantic model, which loads the rest of pydantic. The
last is Python alone. Processor time is printed as well, because other processes disturb it
less. All processes find their bytecode in a folder of their own, as installed packages do; in a
read-only checkout every start would compile it.

    python benchmarks/validate_startup.py
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).parents[1]
VALIDATE = "from cbdsl.cli.main import main; main()"
MODEL = "import pydantic, yaml\nclass M(pydantic.BaseModel):\n    x: float\nM(x=1)"
COMMANDS = {
    "validate": [sys.executable, "-c", VALIDATE, "validate", "robots", "programs"],
    "imports": [sys.executable, "-c", "import pydantic, yaml"],
    "model": [sys.executable, "-c", MODEL],
    "python": [sys.executable, "-c", ""],
}


def seconds(command: list[str], bytecode: str) -> tuple[float, float]:
    """Return wall-clock and processor time of a process.

    Args:
        command: Command that it runs.
        bytecode: Folder of its bytecode.

    Raises:
        CalledProcessError: It failed.
    """
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = bytecode
    start, used = perf_counter(), _processor()
    subprocess.run(command, check=True, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL)
    return perf_counter() - start, _processor() - used


def _processor() -> float:
    """Return the processor time of all processes that have ended so far, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def measure(rounds: int) -> dict[str, list[tuple[float, float]]]:
    """Return wall-clock and processor time by process and round, s, without the first round."""
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in COMMANDS}
    with tempfile.TemporaryDirectory() as bytecode:
        for _ in range(rounds + 1):
            for name, command in COMMANDS.items():
                times[name].append(seconds(command, bytecode))
    # The first round compiles the bytecode.
    return {name: pairs[1:] for name, pairs in times.items()}


def row(own: list[tuple[float, float]], validate: list[tuple[float, float]]) -> dict[str, float]:
    """Return a process's medians, and its multiple of the validation's time in the same round."""
    wall, processor = (statistics.median(column) for column in zip(*own, strict=True))
    pairs = list(zip(validate, own, strict=True))
    return {
        "seconds": round(wall, 3),
        "processor_seconds": round(processor, 3),
        "ratio": round(statistics.median(a[0] / b[0] for a, b in pairs), 2),
        "processor_ratio": round(statistics.median(a[1] / b[1] for a, b in pairs), 2),
    }


def main() -> None:
    """Time the processes and print medians and the multiples of validation."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    rounds = measure(options.rounds)
    result = {name: row(own, rounds["validate"]) for name, own in rounds.items()}
    if options.json:
        sys.stdout.write(json.dumps(result) + "\n")
        return
    for name, figures in result.items():
        wall, processor = 1e3 * figures["seconds"], 1e3 * figures["processor_seconds"]
        times_as_long = f"{figures['ratio']:.2f} x and {figures['processor_ratio']:.2f} x"
        sys.stdout.write(
            f"{name:10}{wall:6.0f} ms, {processor:4.0f} ms of processor; "
            f"validate takes {times_as_long}\n"
        )


if __name__ == "__main__":
    main()
