"""Speed of ``reachtouch`` episodes with the object in view, by engine and by part.

The same seeds run in turn on bullet with the fast renderer and its own, and on mujoco with the fast
renderer and ideal cameras. Each row has the simulated per wall-clock seconds, including the resets
between episodes, and the ratio to bullet with the fast renderer. It also has the shares of

- physics, with joints and load cells,
- rendering: images with their noise, or regions,
- perception: regions and positions,
- control: signals, controllers, law, program,
- the rest.

The exit status is 1 if a limit is missed: 4 times real time on bullet with at most 12 % for
perception, and on mujoco 8 times real time, or 30 times with ideal cameras.

    python benchmarks/episode_speed.py --seed 0 --episodes 3 [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

from stopwatch import Stages, Stopwatch

from cbdsl.backends.backend import embody
from cbdsl.backends.cameras.ideal import IdealCameras
from cbdsl.backends.cameras.rendered import RenderedCameras
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.vision import Vision
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[1]
STAGES: Stages = {
    "physics": [(SimulatedBackend, "step")],
    "rendering": [(RenderedCameras, "take"), (IdealCameras, "take")],
    "perception": [(Vision, "update")],
    "control": [(Signals, "update"), (Actuation, "move"), (ProgramRun, "advance")],
}


class Body(NamedTuple):
    """Backend, its cameras and their renderer, and its targets.

    The targets are a factor of real time, and the percentage of the time for perception.
    """

    backend: str
    cameras: str = "rendered"
    renderer: str = "auto"
    target: float = 0.0
    perception: float = 100.0


BODIES = (
    Body("bullet", target=4.0, perception=12.0),
    Body("bullet", renderer="tiny"),
    Body("mujoco", target=8.0),
    Body("mujoco", cameras="ideal", target=30.0),
)


class Simulation:
    """Episodes on Dexter with one body, and their times."""

    def __init__(self, robot: RobotDocument, program: CheckedProgram, body: Body) -> None:
        vision = robot.vision.model_copy(update={"renderer": body.renderer})
        seeing = robot.model_copy(update={"vision": vision})
        urdf = ROOT / "robots" / robot.model
        self.body = body
        self._backend = embody(body.backend, seeing, urdf, cameras=body.cameras)
        self._runner = Runner(seeing, Kinematics(seeing, urdf), program, self._backend)
        self._simulated = self._wall = 0.0
        self._rewarded = self._episodes = 0
        self._spent: dict[str, float] = defaultdict(float)

    def warm_up(self, stage: StageDocument) -> None:
        """Run one uncounted episode, which compiles the kernels."""
        self._runner.run(stage, 0, "in_view")

    def run(self, stage: StageDocument, seed: int) -> None:
        """Run one episode, with the clocks on."""
        with Stopwatch(STAGES) as watch:
            result = self._runner.run(stage, seed, "in_view")
        self._simulated += result.sim_seconds
        self._wall += result.wall_seconds
        self._rewarded += result.rewarded
        self._episodes += 1
        for name, seconds in watch.seconds.items():
            self._spent[name] += seconds

    def summary(self) -> dict[str, Any]:
        """Return the speed, and percent of the time by stage."""
        self._backend.close()
        shares = {name: 100 * self._spent[name] / self._wall for name in STAGES}
        shares["other"] = 100 - sum(shares.values())
        return {
            "backend": self.body.backend,
            "renderer": self._backend.renderer,
            "episodes": self._episodes,
            "rewarded": self._rewarded,
            "simulated_per_wall": round(self._simulated / self._wall, 2),
            "percent": {name: round(share, 1) for name, share in shares.items()},
        }


def main() -> None:
    """Run episodes and print two lines per body."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--episodes", type=int, default=3)
    parser.add_argument("--json", action="store_true", help="print one JSON object per body")
    options = parser.parse_args()
    library = Library(ROOT)
    robot = library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document
    stage = library.read(library.locate(StageDocument, "table_right"), StageDocument).document
    program = check_program("reachtouch", {}, library)
    simulations = [Simulation(robot, program, body) for body in BODIES]
    for simulation in simulations:
        simulation.warm_up(stage)
    for seed in range(options.seed, options.seed + options.episodes):
        for simulation in simulations:
            simulation.run(stage, seed)
    summaries = [simulation.summary() for simulation in simulations]
    for summary in summaries:
        ratio = summary["simulated_per_wall"] / summaries[0]["simulated_per_wall"]
        summary["over_first"] = round(ratio, 2)
        sys.stdout.write((json.dumps(summary) if options.json else _lines(summary)) + "\n")
    sys.exit(any(misses(body, each) for body, each in zip(BODIES, summaries, strict=True)))


def misses(body: Body, summary: dict[str, Any]) -> bool:
    """Return True if a body is slower than its target, or its perception takes longer."""
    slow = summary["simulated_per_wall"] < body.target
    return bool(slow or summary["percent"]["perception"] > body.perception)


def _lines(summary: dict[str, Any]) -> str:
    shares = "  ".join(f"{name} {share:.0f} %" for name, share in summary["percent"].items())
    return (
        f"{summary['backend']}, {summary['renderer']}: {summary['simulated_per_wall']:.1f} times "
        f"real time, {summary['over_first']:.2f} times bullet's speed, "
        f"{summary['rewarded']} of {summary['episodes']} rewarded\n  {shares}"
    )


if __name__ == "__main__":
    main()
