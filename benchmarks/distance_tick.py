"""Time that distances between links add to a tick of Dexter's two arms.

Episodes without a clearance, with 100 pairs of links drawn at random, and with all pairs run in
turn in one process. In one program the arms stay apart, in the other one their hands cross.
A row gives the median over the rounds of the mean time of a tick, us, and its difference.

    python benchmarks/distance_tick.py
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
from crossing_arms import PROGRAM
from stopwatch import Stopwatch

from cbdsl.api.load import load
from cbdsl.api.open_robot import OpenRobot, open_robot
from cbdsl.kinematics.link_clearance import LinkClearance
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.actuation import Actuation

TARGETS = {
    "apart": ("40 cm, 40 cm, 0 cm", "40 cm, -40 cm, 0 cm"),
    "crossed": ("48 cm, -20 cm, 10 cm", "48 cm, 20 cm, 10 cm"),
}
LEAST = "2 cm"


def pairs_of(chosen: set[tuple[str, str]] | None) -> AbstractContextManager[object]:
    """Let runs keep only some pairs of links apart; all of them for ``None``."""
    if chosen is None:
        return nullcontext()
    counts = partial(LinkClearance, counts=lambda one, other: (one, other) in chosen)
    return patch("cbdsl.runtime.clearance.LinkClearance", counts)


def tick_time(robot: OpenRobot) -> float:
    """Run an episode; return the mean time of ``Actuation.move``, us."""
    ticks: list[float] = []
    with Stopwatch({"move": [(Actuation, "move")]}) as watch:
        robot.run(0, on_tick=lambda tick: ticks.append(tick.observation.time))
    return 1e6 * watch.seconds["move"] / len(ticks)


def measure(folder: Path, name: str, rounds: int) -> dict[str, object]:
    """Return the row of a program."""
    path = folder / "cross.yaml"
    path.write_text(PROGRAM.format(*TARGETS[name]), "utf-8")
    bare, kept = load(path), load(path, clearance=LEAST)
    names = LinkClearance(kept.robot, read_urdf(kept.urdf), 0.02).names
    rng, unique = np.random.default_rng(0), list(dict.fromkeys(names))
    drawn = {unique[k] for k in rng.choice(len(unique), 100, replace=False)}
    times: dict[str, list[float]] = {"none": [], "100 pairs": [], f"{len(names)} pairs": []}
    cases = zip(times, (bare, kept, kept), (None, drawn, None), strict=True)
    for case, request, chosen in list(cases) * rounds:
        with pairs_of(chosen), open_robot(request, backend="kinematic") as robot:
            tick_time(robot)
            times[case].append(tick_time(robot))
    medians = {case: round(statistics.median(each), 1) for case, each in times.items()}
    added = [b - a for a, b in zip(times["none"], times["100 pairs"], strict=True)]
    return {
        "program": name, "us": medians, "added": round(statistics.median(added), 1),
        "range": [round(min(added), 1), round(max(added), 1)],
    }  # fmt: skip


def main() -> None:
    """Print a row for each program."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name in TARGETS:
            row = measure(Path(folder), name, options.rounds)
            sys.stdout.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
