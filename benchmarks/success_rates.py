"""How often shipped programs are rewarded, on seeds and a backend of your choice.

Every rewarded episode is checked against the simulator's own contacts: fingertips have to touch the
thing, all three of a hand in most programs. Rates come with exact (Clopper-Pearson) 95 % intervals.
Episodes are spread over the processors; each is the same as ``cb run`` gives for its seed. Exits
with 1 where a rate misses its target.

    python benchmarks/success_rates.py --episodes 100 --seed 20000 [--only right,left] [--json]
        [--backend mujoco] [--cameras ideal]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from contacts import shown, touching

from cbdsl.numeric.proportion import exact_interval

LEFT = {"arm": "left_arm", "hand": "left_hand"}


@dataclass(frozen=True)
class Condition:
    """A program with parameters on a stage, and the share of episodes that is to be rewarded.

    The share is the least one, or 0 where none is to be; ``None`` where nothing is asked for.
    """

    name: str
    stage: str
    target: float | None
    program: str = "reachtouch"
    values: Mapping[str, str] = field(default_factory=dict)


CONDITIONS = (
    Condition("right", "table_right", 0.97),
    Condition("left", "table_left", 0.97, values=LEFT),
    Condition("right arm on left half", "table_left", 0.9),
    Condition("left arm on right half", "table_right", 0.9, values=LEFT),
    Condition("moving at 5 cm/s", "moving_right", 0.9),
    Condition("noisy and miscalibrated", "noisy_right", 0.9),
    Condition("out of reach", "out_of_reach", 0.0),
    Condition("absent", "absent", 0.0),
    Condition("thrown away", "thrown", 0.0),
    Condition("tactileprobe", "held_right", None, program="tactileprobe"),
    Condition("visualinspect", "spotted_right", None, program="visualinspect"),
    Condition("bimanualtouch", "table_right", None, program="bimanualtouch"),
)


class Body(NamedTuple):
    """A backend and its cameras, by name."""

    backend: str
    cameras: str | None


def run_episodes(condition: Condition, body: Body, seeds: Iterable[int]) -> list[dict[str, Any]]:
    """Run one condition on some seeds, in this process."""
    from cbdsl.backends.backend import embody
    from cbdsl.backends.simulated_backend import SimulatedBackend
    from cbdsl.checking.program import check_program
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.stage import StageDocument
    from cbdsl.runtime.episode import Runner
    from cbdsl.sensing.kinematics import Kinematics
    from cbdsl.yaml_text.library import Library

    library = Library()
    program = check_program(condition.program, condition.values, library)
    robot_file = library.locate(RobotDocument, program.robot)
    robot = library.read(robot_file, RobotDocument).document
    urdf = robot_file.parent / robot.model
    stage_file = library.locate(StageDocument, condition.stage)
    stage = library.read(stage_file, StageDocument).document
    backend = embody(body.backend, robot, urdf, cameras=body.cameras)
    assert isinstance(backend, SimulatedBackend), "contacts are checked in an engine"
    runner = Runner(robot, Kinematics(robot, urdf), program, backend)
    rows = []
    for seed in seeds:
        row = asdict(runner.run(stage, seed))
        things = shown(backend.truth, stage)
        row["touching"] = len(touching(backend.truth, things))
        tops = [float(backend.truth.pose(name).position[2]) for name in stage.fixtures]
        row["fallen"] = any(
            backend.truth.pose(thing).position[2] < min(tops) for thing in things if tops
        )
        rows.append(row)
    backend.close()
    return rows


def summarise(condition: Condition, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return one row of the table."""
    rewarded = [row for row in rows if row["rewarded"]]
    low, high = exact_interval(len(rewarded), len(rows))
    target, share = condition.target, len(rewarded) / len(rows)
    met = target is None or (share >= target if target else not rewarded)
    return {
        "condition": condition.name,
        "rewarded": len(rewarded),
        "episodes": len(rows),
        "interval": [round(low, 3), round(high, 3)],
        "target": target,
        "met": met,
        "rewarded_without_three_contacts": sum(row["touching"] < 3 for row in rewarded),
        "fallen": sum(row["fallen"] for row in rows),
        "sim_seconds": round(sum(row["sim_seconds"] for row in rows) / len(rows), 1),
        "final_states": sorted({row["predicates"][-1] for row in rows if not row["rewarded"]}),
        "failed_seeds": [row["seed"] for row in rows if not row["rewarded"]][:5],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", help="conditions, separated by commas")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--backend", default="bullet")
    parser.add_argument("--cameras", choices=("rendered", "ideal"))
    options = parser.parse_args()
    body = Body(options.backend, options.cameras)
    only = options.only.split(",") if options.only else None
    missed = False
    with ProcessPoolExecutor(options.workers) as pool:
        for condition in CONDITIONS:
            if only is not None and condition.name not in only:
                continue
            seeds = range(options.seed, options.seed + options.episodes)
            parts = [seeds[k :: options.workers] for k in range(options.workers)]
            done = pool.map(run_episodes, [condition] * len(parts), [body] * len(parts), parts)
            row = summarise(condition, [row for rows in done for row in rows])
            missed |= not row["met"]
            print(json.dumps(row) if options.json else _line(row), flush=True)
    sys.exit(int(missed))


def _line(row: dict[str, Any]) -> str:
    low, high = row["interval"]
    target = "" if row["target"] is None else f"{100 * row['target']:.0f} %"
    return (
        f"{row['condition']:<26} {row['rewarded']:>3} of {row['episodes']:<3} "
        f"[{100 * low:5.1f}, {100 * high:5.1f}] %  target {target:<6} "
        f"without contact {row['rewarded_without_three_contacts']}  fallen {row['fallen']}  "
        f"{row['sim_seconds']:6.1f} s  {' '.join(row['final_states'])} {row['failed_seeds'] or ''}"
    )


if __name__ == "__main__":
    main()
