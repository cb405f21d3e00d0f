"""The package's side of the control benchmarks: its inner parts are named in this file alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from stopwatch import Stages

from cbdsl.checking.program import check_program
from cbdsl.control.composition import ComposedArrays, compose_held
from cbdsl.control.law import Law, LawSettings, Step
from cbdsl.control.level import Level
from cbdsl.control.plan import ControllerPlan
from cbdsl.control.stack import TICKS, Stack
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.handle import hold
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.observation import Loads, Observation
from cbdsl.sensing.signals import Signals
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[1]
BALL = np.array([0.45, -0.3, 0.05])  # m
SIZES = np.full(2, 0.004)  # apparent, m^2
LOAD = np.array([0.0, 0.0, -0.5, 0.0, 0.0, 0.0])  # N and N m
CYCLES = 90  # a restart: 1.5 s, before the program changes its action

#: A Jacobian (k, n) and a displacement of its task coordinates (k,), highest priority first.
Rows = Sequence[tuple[Floats, Floats]]

#: The same with the second derivatives of the task coordinates (k, n, n).
Bent = Sequence[tuple[Floats, Floats, Floats]]

#: The methods that ``control_cycle.py`` clocks.
CYCLE_STAGES: Stages = {
    "signals": [(Signals, "update")],
    "tick": [(Actuation, "move")],
    "program": [(ProgramRun, "advance")],
}
#: The methods that ``control_peers.py`` clocks.
PATH_STAGES: Stages = {
    "kinematics": [(Kinematics, "update"), (Kinematics, "place")],
    "signals": [(Signals, "update")],
    "tick": [(Actuation, "move")],
}


def law(sizes: Sequence[int], joints: int) -> Callable[[Rows, Floats], Floats]:
    """Return the control law for one stack, allocated once, as in a running program.

    Args:
        sizes: Number of task coordinates of each level, highest priority first.
        joints: Number of joints n.

    Returns:
        A function of the levels and the joint positions (n,), which returns the displacement (n,).
    """
    limits = np.full(joints, 3.0)
    rule = Law(-limits, limits, LawSettings(joint_step=1.5 / 120))
    stack = Stack([(str(place), size) for place, size in enumerate(sizes)], joints)
    step = Step.of(stack)
    stack.ages[:] = 1  # levels without a past
    handle = hold(ComposedArrays(stack.arrays, rule.arrays(step)))
    spans = [slice(*span) for span in zip(stack.starts, stack.ends, strict=True)]
    rows, wanted = stack.rows[stack.newest], stack.wanted

    def solve(levels: Rows, q: Floats) -> Floats:
        for span, (jacobian, displacement) in zip(spans, levels, strict=True):
            rows[span] = jacobian
            wanted[span] = displacement
        compose_held(handle, q, True)
        return step.displacement

    return solve


def law_with_hessians(
    sizes: Sequence[int], fraction: float, *, curved: bool
) -> Callable[[Bent, Floats], Floats]:
    """Return the law for one stack, with the second derivatives of its task coordinates.

    Args:
        sizes: Number of task coordinates of each level, highest priority first; the last one's
            is the number of joints.
        fraction: Share of the way to its target that each level requests.
        curved: False for the law of first order.
    """
    free = np.full(sizes[-1], math.inf)
    rule = Law(-free, free, LawSettings(joint_step=1.5 / 60))
    stack = Stack([(str(place), size) for place, size in enumerate(sizes)], sizes[-1])

    def solve(levels: Bent, q: Floats) -> Floats:
        stack.clock[0] = (stack.clock[0] + 1) % TICKS
        for place, (jacobian, displacement, hessian) in enumerate(levels):
            second = hessian if curved else None
            stack.put(place, Level(str(place), jacobian, displacement, second, fraction))
        return rule.compose(stack, q).displacement

    return solve


class TwoArms:
    """Control path of a program, from joint positions to joint references.

    Args:
        folder: Folder of the documents.
        period: Control period, s.

    Attributes:
        ready: Posture to keep, rad, shape (14,).
        lower, upper: Joint limits, rad, shape (14,).
    """

    def __init__(self, folder: Path, period: float) -> None:
        library = Library(folder)
        robot = library.read(folder / "two_arms.yaml", RobotDocument).document
        program = check_program(str(folder / "three_objectives.yaml"), {}, library)
        kinematics = Kinematics(robot, folder / "two_arms.urdf")
        self._signals = Signals(robot, kinematics, ())
        self._still = np.zeros(len(self._signals.joints))
        plan = ControllerPlan()
        run = ProgramRun(program, self._signals, plan, period)
        run.begin(np.random.default_rng(0), lambda transition: None)
        self._actuation = Actuation(robot, self._signals, plan, period)
        self._actuation.reset(self._still)
        self._signals.update(Observation(0.0, self._still, self._still, {}, {}))
        run.activate()
        self._active = run.active()
        postures = [effector.postures["ready"] for effector in robot.effectors.values()]
        self.ready = np.concatenate(postures)
        self.lower, self.upper = kinematics.lower, kinematics.upper

    def tick(self, q: Floats) -> Floats:
        """Return joint references for joint positions."""
        self._actuation.reference[:] = q
        self._signals.update(Observation(0.0, q, self._still, {}, {}))
        self._actuation.move(self._active)
        return self._actuation.reference.copy()


class DexterCycle:
    """Dexter's control cycle without a simulator."""

    def __init__(self, robot: RobotDocument, program: CheckedProgram) -> None:
        kinematics = Kinematics(robot, ROOT / "robots" / robot.model)
        self._robot, self._program = robot, program
        self._signals = Signals(robot, kinematics, resources_of(program))
        self._period = 1.0 / robot.control.rate

    @classmethod
    def of(cls, program: str) -> DexterCycle:
        """Return the cycle of a program of Dexter."""
        library = Library(ROOT)
        robot = library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document
        return cls(robot, check_program(program, {}, library))

    def following(self) -> Observation:
        """Return the next tick's observation; after ``CYCLES`` of them restart."""
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
            memory.see(0.0, BALL, SIZES.tolist())
        plan = ControllerPlan()
        self._run = ProgramRun(self._program, signals, plan, self._period)
        self._run.begin(np.random.default_rng(0), lambda transition: None)
        self._actuation = Actuation(
            self._robot, signals, plan, self._period, self._program.all_guards
        )
        self._actuation.reset(positions)
        signals.update(self._observation(0.0, np.zeros(6)))  # the load cells' zero
        self._run.activate()

    def observation(self, tick: int) -> Observation:
        """Return the observation after the joints have reached their references."""
        return self._observation(tick * self._period, LOAD)

    def _observation(self, time: float, load: Floats) -> Observation:
        positions = self._actuation.reference.copy()
        cells = tuple(
            (hand, finger) for hand, cells in self._robot.load_cells.items() for finger in cells
        )
        loads = Loads(cells, np.tile(load, (len(cells), 1)))
        return Observation(time, positions, np.zeros(len(positions)), loads, {})

    def tick(self, observation: Observation) -> None:
        """Run one control cycle, as in an episode."""
        self._signals.update(observation)
        self._actuation.move(self._run.active())
        self._run.advance()

    @property
    def action(self) -> str:
        """The running action, and how many levels act."""
        action, step = self._run.action, self._actuation.step
        return f"{action.name if action else 'nothing'}, {len(step.levels) if step else 0} levels"
