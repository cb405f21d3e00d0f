"""Time that distances between links add to a tick of Dexter's two arms.

Episodes without a clearance, with 100 pairs of links drawn at random, and with all pairs run in
turn in one process. In one program the arms stay apart, in the other one their hands cross.
Episodes repeat, so that the time of a tick is the least one over the rounds, and other processes do
not count. A row gives the mean over all ticks, us, and its difference from that without a clearance
and its ratio to it.

    python benchmarks/distance_tick.py
"""

from __future__ import annotations

import argparse
import json
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
from cbdsl.numeric.arrays import Floats
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


def tick_times(robot: OpenRobot) -> Floats:
    """Run an episode; return the time of ``Actuation.move`` in each tick, us."""
    ends: list[float] = []
    with Stopwatch({"move": [(Actuation, "move")]}) as watch:
        robot.run(0, on_tick=lambda _: ends.append(watch.seconds["move"]))
    return 1e6 * np.diff(ends)


def measure(folder: Path, name: str, rounds: int) -> dict[str, object]:
    """Return the row of a program."""
    path = folder / "cross.yaml"
    path.write_text(PROGRAM.format(*TARGETS[name]), "utf-8")
    bare, kept = load(path), load(path, clearance=LEAST)
    names = LinkClearance(kept.robot, read_urdf(kept.urdf), 0.02).names
    rng, unique = np.random.default_rng(0), list(dict.fromkeys(names))
    drawn = {unique[k] for k in rng.choice(len(unique), 100, replace=False)}
    times: dict[str, list[Floats]] = {"none": [], "100 pairs": [], f"{len(names)} pairs": []}
    cases = zip(times, (bare, kept, kept), (None, drawn, None), strict=True)
    for case, request, chosen in list(cases) * rounds:
        with pairs_of(chosen), open_robot(request, backend="kinematic") as robot:
            tick_times(robot)
            times[case].append(tick_times(robot))
    least = {case: np.min(each, axis=0) for case, each in times.items()}
    means = {case: round(float(each.mean()), 1) for case, each in least.items()}
    row = {"program": name, "us": means, "most": round(float(least["100 pairs"].max()), 1)}
    added = {case: round(mean - means["none"], 1) for case, mean in means.items()}
    ratio = {case: round(mean / means["none"], 1) for case, mean in means.items()}
    return row | {"added": added, "ratio": ratio}


def main() -> None:
    """Print a row for each program."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=10)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name in TARGETS:
            row = measure(Path(folder), name, options.rounds)
            sys.stdout.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
