"""Success rate of ``touch_table``, and contact of the fingertips with the table at the reward.

Every rewarded episode is checked against the simulator's own contacts between load cells and table.
Some fingertip has to be in contact in at least half of the ticks of the last 0.1 s. (Fingertips on
a table press in turn: in 0 to 5 of the last 240 steps none is in contact, while the mean force is
2 N.) Rates have exact (Clopper-Pearson) 95 % intervals. The exit status is 1 if a rate is below its
target, or if an episode is rewarded without contact.

    python benchmarks/touch_table.py --episodes 60 --seed 5000000 [--cameras rendered] [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import deque
from collections.abc import Mapping
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
from cbdsl.sensing.observation import Cell
from cbdsl.yaml_text.library import Library

TARGET = 0.95
LAST = 0.1  # s
HANDS = {
    "right": {"arm": "right_arm", "hand": "right_hand"},
    "left": {"arm": "left_arm", "hand": "left_hand"},
}


def run_episodes(
    values: Mapping[str, str], cameras: str, first: int, episodes: int
) -> list[dict[str, Any]]:
    """Run the program with one hand on successive seeds."""
    library = Library()
    program = check_program("touch_table", values, library)
    robot_file = library.locate(RobotDocument, program.robot)
    robot = library.read(robot_file, RobotDocument).document
    urdf = robot_file.parent / robot.model
    stage = library.read(library.locate(StageDocument, "bare_table"), StageDocument).document
    backend = embody("bullet", robot, urdf, cameras=cameras)
    assert isinstance(backend, SimulatedBackend), "contacts are checked in an engine"
    runner = Runner(robot, Kinematics(robot, urdf), program, backend)
    rows = []
    for seed in range(first, first + episodes):
        last: deque[frozenset[Cell]] = deque(maxlen=round(LAST / backend.control_period))

        def note(_: Tick, last: deque[frozenset[Cell]] = last) -> None:
            cells = touching(backend.truth, ["table"])
            last.append(frozenset(each for each in cells if each[0] == values["hand"]))

        result = runner.run(stage, seed, on_tick=note)
        pressing = [cells for cells in last if cells]
        is_pressing = 2 * len(pressing) >= len(last)
        rows.append(
            {
                "seed": seed,
                "rewarded": result.rewarded,
                "seconds": result.sim_seconds,
                "in_contact": len(frozenset().union(*pressing)) if is_pressing else 0,
            }
        )
    backend.close()
    return rows


def summarise(hand: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return one row of the table."""
    rewarded = [row for row in rows if row["rewarded"]]
    low, high = exact_interval(len(rewarded), len(rows))
    return {
        "hand": hand,
        "rewarded": len(rewarded),
        "episodes": len(rows),
        "interval": [round(low, 3), round(high, 3)],
        "target": TARGET,
        "without_contact": sum(not row["in_contact"] for row in rewarded),
        "fingertips": round(sum(row["in_contact"] for row in rewarded) / max(1, len(rewarded)), 2),
        "sim_seconds": round(sum(row["seconds"] for row in rows) / len(rows), 1),
        "failed_seeds": [row["seed"] for row in rows if not row["rewarded"]],
    }


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--episodes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=5_000_000)
    parser.add_argument("--cameras", choices=("rendered", "ideal"), default="rendered")
    parser.add_argument("--only", choices=tuple(HANDS), help="one hand")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    missed = False
    for hand, values in HANDS.items():
        if options.only not in (None, hand):
            continue
        rows = run_episodes(values, options.cameras, options.seed, options.episodes)
        row = summarise(hand, rows)
        missed |= row["rewarded"] < TARGET * row["episodes"] or row["without_contact"] > 0
        print(json.dumps(row) if options.json else _line(row), flush=True)
    sys.exit(int(missed))


def _line(row: dict[str, Any]) -> str:
    low, high = row["interval"]
    return (
        f"{row['hand']:<6} {row['rewarded']:>3} of {row['episodes']:<3} "
        f"[{100 * low:5.1f}, {100 * high:5.1f}] %  target >= {100 * TARGET:.0f} %  "
        f"without contact {row['without_contact']}  fingertips {row['fingertips']}  "
        f"{row['sim_seconds']} s  {row['failed_seeds'] or ''}"
    )


if __name__ == "__main__":
    main()
