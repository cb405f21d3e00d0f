"""How often ``find_by_touch`` touches a thing in the dark, by the simulator's own contacts.

A thing is found when the program says so and a hand touches it, and not the table. The share comes
with an exact (Clopper-Pearson) 95 % interval. Exits with 1 where the target is missed, or where the
program says once that it found an object that no hand touches.

    python benchmarks/find_by_touch.py --episodes 20 --seed 5000000 [--backend bullet] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

import numpy as np

from cbdsl.numeric.proportion import exact_interval

TARGET = 0.9


def run_episodes(backend: str, seeds: Iterable[int]) -> list[dict[str, Any]]:
    """Look for some things in the dark, in this process."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.engine import Engine
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    request, episodes = read_request("find_by_touch", None, None, {}), []
    with simulation(request, backend) as (body, kinematics):
        assert isinstance(body, GroundTruthProvider)
        assert isinstance(body.truth, Engine)
        truth = body.truth
        runner = Runner(request.robot, kinematics, request.program, body)
        for seed in seeds:
            result = runner.run(request.stage, seed, "dark")
            there = set(truth.names()).intersection(request.stage.things)
            # A try without success has two transitions: it begins, and ends.
            states = result.predicates[1:]
            episodes.append(
                {
                    "seed": seed,
                    "said": result.outcome == "success",
                    "touched": any(map(truth.touched, there)),
                    "tries": states.count("0") or len(states),
                    "seconds": round(result.sim_seconds, 1),
                }
            )
    return episodes


def summarise(episodes: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the result."""
    found = [each for each in episodes if each["said"] and each["touched"]]
    low, high = exact_interval(len(found), len(episodes))
    return {
        "found": len(found),
        "episodes": len(episodes),
        "interval": [round(low, 3), round(high, 3)],
        "false": sum(each["said"] and not each["touched"] for each in episodes),
        "tries": float(np.median([each["tries"] for each in episodes])),
        "sim_seconds": float(np.median([each["seconds"] for each in episodes])),
        "missed": [each["seed"] for each in episodes if each not in found],
        "met": len(found) >= TARGET * len(episodes)
        and not any(each["said"] and not each["touched"] for each in episodes),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--backend", default="mujoco")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.episodes)
    parts = [seeds[k :: options.workers] for k in range(options.workers)]
    with ProcessPoolExecutor(options.workers) as pool:
        rows = pool.map(partial(run_episodes, options.backend), parts)
        row = summarise(sorted((each for some in rows for each in some), key=lambda e: e["seed"]))
    print(json.dumps(row) if options.json else "  ".join(f"{k} {v}" for k, v in row.items()))
    sys.exit(not row["met"])


if __name__ == "__main__":
    main()
