"""Episodes of ``reachtouch`` with the thing in view: how fast they run, and what takes the time.

The same seeds run with the fast renderer and with the simulator's own, turn by turn. For each it
prints simulated per wall-clock seconds, with the resets between episodes, and the shares of
physics (with joints and load cells), rendering (with the images' noise), perception (regions and
positions), control (signals, controllers, law, program) and everything else. Run with
``python benchmarks/episode_speed.py --seeds 0 1 2``.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

from stopwatch import Stages, Stopwatch

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.cameras.rendered import RenderedCameras
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision import Vision
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[1]
STAGES: Stages = {
    "physics": [(BulletBackend, "step")],
    "rendering": [(RenderedCameras, "take")],
    "perception": [(Vision, "update")],
    "control": [(Signals, "update"), (Actuation, "move"), (ProgramRun, "advance")],
}


class Simulation:
    """Episodes on Dexter with one kind of renderer, and what they took."""

    def __init__(self, robot: RobotDocument, program: CheckedProgram, renderer: str) -> None:
        vision = robot.vision.model_copy(update={"renderer": renderer})
        seeing = robot.model_copy(update={"vision": vision})
        urdf = ROOT / "robots" / robot.model
        self._backend = BulletBackend(seeing, urdf)
        self._runner = Runner(seeing, Kinematics(seeing, urdf), program, self._backend)
        self._simulated = self._wall = 0.0
        self._rewarded = self._episodes = 0
        self._spent: dict[str, float] = defaultdict(float)

    def run(self, stage: StageDocument, seed: int) -> None:
        """One episode, with the clocks on."""
        with Stopwatch(STAGES) as watch:
            result = self._runner.run(stage, seed, "in_view")
        self._simulated += result.sim_seconds
        self._wall += result.wall_seconds
        self._rewarded += result.rewarded
        self._episodes += 1
        for name, seconds in watch.seconds.items():
            self._spent[name] += seconds

    def summary(self) -> dict[str, Any]:
        """Speed, and percent of the time by stage."""
        self._backend.close()
        shares = {name: 100 * self._spent[name] / self._wall for name in STAGES}
        shares["other"] = 100 - sum(shares.values())
        return {
            "renderer": self._backend.renderer,
            "episodes": self._episodes,
            "rewarded": self._rewarded,
            "simulated_per_wall": round(self._simulated / self._wall, 2),
            "percent": {name: round(share, 1) for name, share in shares.items()},
        }


def main() -> None:
    """Run episodes and print a line per renderer."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--json", action="store_true", help="print one JSON object per renderer")
    options = parser.parse_args()
    library = Library(ROOT)
    robot = library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document
    stage = library.read(library.locate(StageDocument, "table_right"), StageDocument).document
    program = check_program("reachtouch", {}, library)
    simulations = [Simulation(robot, program, renderer) for renderer in ("auto", "tiny")]
    for seed in options.seeds:
        for simulation in simulations:
            simulation.run(stage, seed)
    for summary in [simulation.summary() for simulation in simulations]:
        if options.json:
            sys.stdout.write(json.dumps(summary) + "\n")
            continue
        shares = "  ".join(f"{name} {share:.0f} %" for name, share in summary["percent"].items())
        sys.stdout.write(
            f"{summary['renderer']}: {summary['simulated_per_wall']:.1f} times real time, "
            f"{summary['rewarded']} of {summary['episodes']} rewarded\n  {shares}\n"
        )


if __name__ == "__main__":
    main()
