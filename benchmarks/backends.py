"""Episodes per second on each backend, with the costs of the kinematic one.

The same seeds run on both backends in turn: after each episode on bullet, all seeds run one after
another on the kinematic backend, as in normal use. A single episode directly after the renderer
would mostly measure cold caches. For each program, the output has the time of an episode on each
backend and their ratio. It also has the shares of a kinematic control tick: those of the backend,
and of the signals, law and program of the robot. Both backends share the latter, which thus bounds
the ratio. Times are processor times, because other work on the machine disturbs them less.

    python benchmarks/backends.py --episodes 10
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time
from typing import Any

from stopwatch import Stages, Stopwatch

from cbdsl.backends.backend import Backend
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.vision import Vision
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[1]
STAGES: Stages = {
    "backend": [(KinematicBackend, "step"), (KinematicBackend, "reset")],
    "perception": [(Vision, "update")],
    "signals": [(Signals, "update")],
    "law": [(Actuation, "move")],
    "program": [(ProgramRun, "advance")],
}
PROGRAMS = {"searchtrack": "table_right", "reachtouch": "table_right", "tactileprobe": "held_right"}


@dataclass
class Spent:
    """Processor time of one program's episodes, s, and their ticks; by stage where clocked."""

    seconds: list[float] = field(default_factory=list)
    ticks: int = 0
    stages: dict[str, float] = field(default_factory=lambda: defaultdict(float))

    def run(self, runner: Runner, stage: StageDocument, seed: int) -> None:
        """Run one episode."""
        began = process_time()
        result = runner.run(stage, seed)
        self.seconds.append(process_time() - began)
        self.ticks += result.ticks

    @property
    def mean(self) -> float:
        """Time of an episode, s."""
        return sum(self.seconds) / len(self.seconds)

    def per_tick(self) -> float:
        """Return the time per tick, us."""
        return 1e6 * sum(self.seconds) / self.ticks


def compare(
    robot: RobotDocument,
    backends: Mapping[str, Backend],
    library: Library,
    name: str,
    episodes: int,
) -> dict[str, Any]:
    """Run one program on all backends."""
    urdf = ROOT / "robots" / robot.model
    stage = library.read(library.locate(StageDocument, PROGRAMS[name]), StageDocument).document
    program = check_program(name, {}, library)
    runners = {
        key: Runner(robot, Kinematics(robot, urdf), program, backend)
        for key, backend in backends.items()
    }
    spent, clocked = {key: Spent() for key in runners}, Spent()
    runners["kinematic"].run(stage, 0)  # compiles the kernels
    for seed in range(episodes):
        spent["bullet"].run(runners["bullet"], stage, seed)
        for each in range(episodes):
            spent["kinematic"].run(runners["kinematic"], stage, each)
        # Clocks slow an episode down, so that its stages are measured in an additional episode.
        with Stopwatch(STAGES, process_time) as watch:
            clocked.run(runners["kinematic"], stage, seed)
        for part, seconds in watch.seconds.items():
            clocked.stages[part] += seconds
    means = {key: each.mean for key, each in spent.items()}
    per_tick = {part: 1e6 * seconds / clocked.ticks for part, seconds in clocked.stages.items()}
    per_tick["other"] = clocked.per_tick() - sum(per_tick.values())
    # A backend without any cost would still leave this share of the time.
    shared = 1 - per_tick["backend"] / clocked.per_tick()
    return {
        "program": name,
        "episodes": episodes,
        "ms_per_episode": {key: round(1e3 * mean, 1) for key, mean in means.items()},
        "ratio": round(means["bullet"] / means["kinematic"], 1),
        "us_per_tick": {key: round(each.per_tick()) for key, each in spent.items()},
        "us_per_tick_by_part": {part: round(value, 1) for part, value in per_tick.items()},
        "ratio_of_a_backend_that_takes_no_time": round(
            means["bullet"] / means["kinematic"] / shared, 1
        ),
    }


def main() -> None:
    """Run episodes and print a line or two per program."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--programs", nargs="+", choices=PROGRAMS, default=list(PROGRAMS))
    parser.add_argument("--json", action="store_true", help="print one JSON object per program")
    options = parser.parse_args()
    library = Library(ROOT)
    robot = library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document
    urdf = ROOT / "robots" / robot.model
    backends: dict[str, Backend] = {
        "bullet": BulletBackend(robot, urdf),
        "kinematic": KinematicBackend(robot, urdf),
    }
    for name in options.programs:
        row = compare(robot, backends, library, name, options.episodes)
        if options.json:
            sys.stdout.write(json.dumps(row) + "\n")
            continue
        times = row["ms_per_episode"]
        parts = "  ".join(f"{part} {us:.0f}" for part, us in row["us_per_tick_by_part"].items())
        sys.stdout.write(
            f"{name}: {times['bullet']:.0f} ms an episode on bullet, {times['kinematic']:.0f} on "
            f"kinematic: {row['ratio']:.1f} times as fast; "
            f"{row['ratio_of_a_backend_that_takes_no_time']:.1f} without any backend\n"
            f"  microseconds a tick: {parts}\n"
        )


if __name__ == "__main__":
    main()
