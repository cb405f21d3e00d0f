"""Kinematic REACHTOUCH episodes per second of processor time, also against another checkout.

Each checkout runs in a process of its own, with the interpreter of its own ``.venv``. It is called
through the command line alone, so that any commit can be measured. The processes take turns by
blocks of episodes with the same seeds. The first episode of a block includes the start-up and is
not counted. Other work on the machine disturbs processor time less than wall time, and both sides
alike.

    python benchmarks/kinematic_speed.py --against ../other-checkout
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

HERE = Path(__file__).parents[1]

#: The process of a checkout: runs ``cb`` with the arguments of each line that it reads, and puts
#: its processor time before each line that ``cb`` prints.
WORKER = """
import json, os, sys
from time import process_time
from cbdsl.cli.main import main

class Clocked:
    def __init__(self, stream):
        self._stream = stream
    def write(self, text):
        return self._stream.write(f"{process_time()} {text}" if text.strip() else text)
    def __getattr__(self, name):
        return getattr(self._stream, name)

sys.stdout = Clocked(os.fdopen(os.dup(1), "w"))  # cb may lead descriptor 1 elsewhere
for line in sys.stdin:
    sys.argv = ["cb", *json.loads(line)]
    try:
        main()
    except SystemExit as done:
        if done.code:
            raise
"""


class Block(NamedTuple):
    """Block of episodes.

    Attributes:
        seconds: Processor time of an episode.
        ticks: Ticks of all episodes.
        rewarded: Number of rewarded episodes.
    """

    seconds: float
    ticks: int
    rewarded: int


class Checkout:
    """A process that runs a checkout's episodes.

    Args:
        folder: Folder of the checkout, with its ``.venv``.
    """

    def __init__(self, folder: Path) -> None:
        python = folder / ".venv" / "bin" / "python"
        if not python.exists():
            raise SystemExit(f"{folder} has no .venv; run its setup.sh")
        self.process = subprocess.Popen(
            [str(python), "-c", WORKER],
            cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def run(self, program: str, seed: int, episodes: int) -> Block:
        """Run one block; one uncounted episode comes first."""
        command = ["run", program, "--backend", "kinematic", "--json"]
        command += ["--seed", str(seed), "--episodes", str(episodes + 1)]
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(command) + "\n")
        self.process.stdin.flush()
        times, results = zip(*(self._line() for _ in range(episodes + 1)), strict=True)
        return Block(
            # The uncounted episode prints its line at its end, where the counted ones begin.
            seconds=(times[-1] - times[0]) / episodes,
            ticks=sum(result["ticks"] for result in results[1:]),
            rewarded=sum(result["rewarded"] for result in results[1:]),
        )

    def _line(self) -> tuple[float, dict[str, Any]]:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{self.process.args!r} has ended with code {self.process.wait()}")
        time, _, text = line.partition(" ")
        return float(time), json.loads(text)


def summary(blocks: list[Block]) -> dict[str, float]:
    """Return medians over the blocks of a checkout, and sums."""
    return {
        "episodes_per_second": round(1 / statistics.median(b.seconds for b in blocks), 1),
        "ticks": sum(block.ticks for block in blocks),
        "rewarded": sum(block.rewarded for block in blocks),
    }


def main() -> None:
    """Run blocks in turn and print a line per checkout."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--against", type=Path, metavar="DIR", help="another checkout")
    parser.add_argument("--program", default="reachtouch")
    parser.add_argument("--blocks", type=int, default=8)
    parser.add_argument("--episodes", type=int, default=40, help="in a block")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    folders = {"here": HERE} | ({"against": options.against} if options.against else {})
    blocks: dict[str, list[Block]] = {name: [] for name in folders}
    with ExitStack() as processes:
        checkouts = {name: Checkout(folder) for name, folder in folders.items()}
        for checkout in checkouts.values():
            processes.enter_context(checkout.process)
            checkout.run(options.program, 0, 1)  # loads or compiles all that is compiled
        for number in range(options.blocks):
            # The alternating order cancels a trend of the machine's speed.
            turns = list(checkouts) if number % 2 == 0 else list(checkouts)[::-1]
            for name in turns:
                seed = number * options.episodes
                blocks[name].append(checkouts[name].run(options.program, seed, options.episodes))
    result: dict[str, Any] = {name: summary(each) for name, each in blocks.items()}
    if options.against:
        pairs = zip(blocks["against"], blocks["here"], strict=True)
        result["ratio"] = round(statistics.median(a.seconds / b.seconds for a, b in pairs), 2)
    if options.json:
        sys.stdout.write(json.dumps(result) + "\n")
        return
    for name in folders:
        row = result[name]
        sys.stdout.write(
            f"{name:8}{row['episodes_per_second']:6.1f} episodes a second of processor time, "
            f"{row['rewarded']} of {options.blocks * options.episodes} rewarded\n"
        )
    if options.against:
        sys.stdout.write(f"here is {result['ratio']:.2f} times as fast\n")


if __name__ == "__main__":
    main()
