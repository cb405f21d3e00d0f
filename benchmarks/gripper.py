"""How often ``panda_pick`` puts a cube where it belongs, by the simulator's own poses.

A cube is placed when it lies within 2 cm of its place, flat on the table. The share comes with an
exact (Clopper-Pearson) 95 % interval. Exits with 1 where the target is missed.

    python benchmarks/gripper.py --episodes 100 --seed 5000000 [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from cbdsl.numeric.proportion import exact_interval

TARGET = 0.95
PLACE, CLOSE = (0.45, 0.30), 0.02  # m
FLAT = 10.0  # deg


class Episode(NamedTuple):
    """Episode with one cube.

    Attributes:
        seed: Seed of the episode.
        placed: True if the cube lies at its goal.
        error: Distance from the goal, mm.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    seed: int
    placed: bool
    error: float
    seconds: float
    ending: str


def run_episodes(seeds: Iterable[int]) -> list[Episode]:
    """Pick and place some cubes, in this process."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.documents.form import BoxForm
    from cbdsl.runtime.episode import Runner

    request, episodes = read_request("panda_pick", None, None, {}), []
    form = request.stage.things["cube"].form
    assert isinstance(form, BoxForm)
    half = form.size[2][0] / 2  # which is not drawn
    with simulation(request, "bullet") as (backend, kinematics):
        assert isinstance(backend, GroundTruthProvider)
        runner = Runner(request.robot, kinematics, request.program, backend)
        for seed in seeds:
            result = runner.run(request.stage, seed)
            cube = backend.truth.pose("cube")
            error = math.dist(cube.position[:2], PLACE)
            # Any side may be below.
            tilt = math.degrees(math.acos(min(1.0, float(np.abs(cube.rotation[2]).max()))))
            flat = tilt < FLAT and abs(cube.position[2] - half) < CLOSE / 4
            placed = error < CLOSE and flat
            row = Episode(seed, placed, round(1e3 * error, 1), result.sim_seconds, result.ending)
            episodes.append(row)
    return episodes


def summarise(episodes: Sequence[Episode]) -> dict[str, Any]:
    """Return the result."""
    placed = [each for each in episodes if each.placed]
    errors = [each.error for each in placed] or [math.nan]
    low, high = exact_interval(len(placed), len(episodes))
    return {
        "placed": len(placed),
        "episodes": len(episodes),
        "interval": [round(low, 3), round(high, 3)],
        "error_mm": [round(float(each), 1) for each in np.quantile(errors, [0.5, 0.9, 1.0])],
        "sim_seconds": round(sum(each.seconds for each in episodes) / len(episodes), 1),
        "missed": [(each.seed, each.ending) for each in episodes if not each.placed],
        "met": len(placed) >= TARGET * len(episodes),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.episodes)
    parts = [seeds[k :: options.workers] for k in range(options.workers)]
    with ProcessPoolExecutor(options.workers) as pool:
        row = summarise(sorted(each for some in pool.map(run_episodes, parts) for each in some))
    print(json.dumps(row) if options.json else "  ".join(f"{k} {v}" for k, v in row.items()))
    sys.exit(not row["met"])


if __name__ == "__main__":
    main()
