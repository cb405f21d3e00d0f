"""A control cycle of Dexter in ``reach ◁ touch``, from sensors to joint references, without images.

Six controllers act on eleven joints: touch, approach, orient and posture, above preshape and home.
The joints follow their references exactly, the ball's position is remembered, and the fingertips
feel a constant load. Each cycle is timed as a whole; a second series with a clock around every
stage gives the split. Run with ``python benchmarks/control_cycle.py``.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from pathlib import Path
from time import perf_counter

import numpy as np
from stopwatch import Stages, Stopwatch

from cbdsl.checking.program import check_program
from cbdsl.control.crew import Crew
from cbdsl.control.law import Law
from cbdsl.control.signal import Floats
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.episode import resources_of
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[1]
BALL = np.array([0.45, -0.3, 0.05])  # m
SIZES = np.full(2, 0.004)  # apparent, m^2
LOAD = np.array([0.0, 0.0, -0.5, 0.0, 0.0, 0.0])  # N and N m
CYCLES = 90  # a restart: 1.5 s, before the program changes its action


class Cycle:
    """Dexter's control path without a simulator."""

    def __init__(self, robot: RobotDocument, program: CheckedProgram) -> None:
        kinematics = Kinematics(robot, ROOT / "robots" / robot.model)
        self._robot, self._program = robot, program
        self._signals = Signals(robot, kinematics, resources_of(program))
        self._period = 1.0 / robot.control.rate

    @classmethod
    def of(cls, program: str) -> Cycle:
        """The cycle of a program of Dexter."""
        library = Library(ROOT)
        robot = library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document
        return cls(robot, check_program(program, {}, library))

    def following(self) -> Observation:
        """The next tick's observation; after ``CYCLES`` of them it begins again."""
        self._tick += 1
        if self._tick >= CYCLES:
            self.restart()
        return self.observation(max(self._tick, 1))

    def restart(self) -> None:
        """Begin where ``reach ◁ touch`` begins: the arm at home, the ball in view."""
        self._tick = 0
        signals, joints = self._signals, self._signals.joints
        positions = np.zeros(len(joints))
        for name, effector in self._robot.effectors.items():
            if effector.start is not None:
                positions[joints.of(name)] = effector.postures[effector.start]
        signals.reset()
        for memory in signals.vision.memories.values():
            memory.see(0.0, BALL, SIZES)
        self._run = ProgramRun(self._program, signals, self._period)
        self._run.begin(np.random.default_rng(0), lambda transition: None)
        self._actuation = Actuation(self._robot, signals, self._period)
        self._actuation.reset(positions)
        signals.update(self._observation(0.0, np.zeros(6)))  # the load cells' zero
        self._run.activate()

    def observation(self, tick: int) -> Observation:
        """What is sensed when the joints have reached their references."""
        return self._observation(tick * self._period, LOAD)

    def _observation(self, time: float, load: Floats) -> Observation:
        positions = self._actuation.reference.copy()
        loads = {
            (hand, finger): load
            for hand, fingers in self._robot.load_cells.items()
            for finger in fingers
        }
        return Observation(time, positions, np.zeros(len(positions)), loads, {})

    def tick(self, observation: Observation) -> None:
        """One control cycle, as an episode has it."""
        self._signals.update(observation)
        self._actuation.move(self._run.active())
        self._run.advance()

    @property
    def action(self) -> str:
        """What runs, and how many levels act."""
        action, step = self._run.action, self._actuation.step
        return f"{action.name if action else 'nothing'}, {len(step.levels) if step else 0} levels"


def whole(cycle: Cycle, restarts: int) -> list[float]:
    """Times of whole cycles, us."""
    times = []
    for _ in range(restarts):
        cycle.restart()
        for tick in range(1, CYCLES):
            observation = cycle.observation(tick)
            start = perf_counter()
            cycle.tick(observation)
            times.append((perf_counter() - start) * 1e6)
    return times


STAGES: Stages = {
    "signals": [(Signals, "update")],
    "controllers": [(ControllerRun, "sense"), (Crew, "act")],
    "law": [(Law, "advance")],
    "bounds": [(Actuation, "move")],
    "program": [(ProgramRun, "advance")],
}


def split(cycle: Cycle, restarts: int) -> dict[str, list[float]]:
    """Times by stage, us; ``bounds`` is what moving costs beside controllers and law."""
    times: dict[str, list[float]] = {stage: [] for stage in STAGES}
    with Stopwatch(STAGES) as watch:
        for _ in range(restarts):
            cycle.restart()
            for tick in range(1, CYCLES):
                observation = cycle.observation(tick)
                watch.seconds.clear()
                cycle.tick(observation)
                for stage, seconds in watch.seconds.items():
                    times[stage].append(seconds * 1e6)
    return times


def main() -> None:
    """Time cycles and print medians."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--restarts", type=int, default=20, help="series of cycles")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    cycle = Cycle.of("reachtouch")
    times = {"cycle": whole(cycle, options.restarts), **split(cycle, options.restarts)}
    medians = {stage: round(statistics.median(values), 1) for stage, values in times.items()}
    if options.json:
        sys.stdout.write(json.dumps({"action": cycle.action, "microseconds": medians}) + "\n")
        return
    lines = [f"  {stage:12}{time:6.0f} us" for stage, time in medians.items()]
    sys.stdout.write("\n".join([f"{cycle.action}; medians", *lines]) + "\n")


if __name__ == "__main__":
    main()
