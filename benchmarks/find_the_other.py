"""Success rate of ``find_the_other``, which touches one of two red balls and then the other.

Every rewarded episode is checked against the simulator's own contacts. Three fingertips must have
been on one ball, and at the end three must be on the other one and none on the first. Rates have
exact (Clopper-Pearson) 95 % intervals. The exit status is 1 if the rate is below its target, or if
an episode is rewarded without these contacts.

    python benchmarks/find_the_other.py --episodes 20 --seed 5000000 [--backend kinematic] [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from contacts import touching

from cbdsl.backends.backend import embody
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.numeric.proportion import exact_interval
from cbdsl.runtime.episode import Runner, Tick
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.yaml_text.library import Library

TARGET, FINGERS = 0.95, 3
_BALLS = ("one", "other")


def run_episodes(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Run the program on successive seeds."""
    library = Library()
    program = check_program("find_the_other", {}, library)
    robot_file = library.locate(RobotDocument, program.robot)
    robot = library.read(robot_file, RobotDocument).document
    urdf = robot_file.parent / robot.model
    stage = library.read(library.locate(StageDocument, "two_red_balls"), StageDocument).document
    backend = embody(options.backend, robot, urdf, cameras=options.cameras)
    assert isinstance(backend, SimulatedBackend), "contacts are checked in an engine"
    runner = Runner(robot, Kinematics(robot, urdf), program, backend)
    rows = []
    for seed in range(options.seed, options.seed + options.episodes):
        held: list[str] = []

        def note(_: Tick, held: list[str] = held) -> None:
            for name in _BALLS:
                if name not in held and len(touching(backend.truth, [name])) >= FINGERS:
                    held.append(name)

        result = runner.run(stage, seed, on_tick=note)
        at_end = [len(touching(backend.truth, [name])) for name in held]
        rows.append(
            {
                "seed": seed,
                "rewarded": result.rewarded,
                "in_turn": len(held) == len(_BALLS) and at_end[0] == 0 and at_end[1] >= FINGERS,
                "seconds": result.sim_seconds,
                "ending": result.ending,
            }
        )
    backend.close()
    return rows


def summarise(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the result."""
    rewarded = [row for row in rows if row["rewarded"]]
    low, high = exact_interval(len(rewarded), len(rows))
    return {
        "rewarded": len(rewarded),
        "episodes": len(rows),
        "interval": [round(low, 3), round(high, 3)],
        "target": TARGET,
        "without_contacts": [row["seed"] for row in rewarded if not row["in_turn"]],
        "sim_seconds": round(sum(row["seconds"] for row in rows) / len(rows), 1),
        "failed": {row["seed"]: row["ending"] for row in rows if not row["rewarded"]},
    }


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=5_000_000)
    parser.add_argument("--backend", default="bullet")
    parser.add_argument("--cameras", choices=("rendered", "ideal"))
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    row = summarise(run_episodes(options))
    if options.json:
        print(json.dumps(row))
    else:
        for key, value in row.items():
            print(f"{key:<18} {value}")
    sys.exit(int(row["rewarded"] < TARGET * row["episodes"] or bool(row["without_contacts"])))


if __name__ == "__main__":
    main()
