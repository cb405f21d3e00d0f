"""One tick of the same inverse kinematics with this package and with others, in turn.

Two arms of seven joints: a reach with one hand, that arm's manipulability, and a posture of both
arms, with joint limits. All get the same URDF, postures and goals, in the same process, turn by
turn. What is not installed is left out. Those that have no manipulability solve less, and say so.
Weights stand for priorities where there are none.

Ours is timed twice: the path from joint positions to joint references, with predicates as a running
program has it, and the whole control cycle of Dexter (``control_cycle.py``).

Everyone solves every posture twice: in blocks, several ticks in a row, and tick by tick in turn
with all others. A robot sees the blocks: its control loop runs the same code on the same data, tick
after tick, so that both stay in the processor's caches. In single turns everyone finds there the
code and data of the others, which would not be in the same loop, and has to load its own again:
that is a larger part of a short tick than of a long one.

Run with ``python benchmarks/control_peers.py``; it takes a minute or two.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import statistics
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from control_cycle import Cycle
from stopwatch import Stages, Stopwatch

from cbdsl.checking.program import check_program
from cbdsl.control.crew import Crew
from cbdsl.control.law import Law
from cbdsl.control.signal import Floats
from cbdsl.control.task import Task
from cbdsl.documents.robot import RobotDocument
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.tips import Tips
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[1]
DOCUMENTS = Path(__file__).parent / "two_arms"
GOAL = np.array([0.45, -0.3, 0.2])  # m
PERIOD = 1 / 60  # s

Tick = Callable[[Floats], object]


@dataclass(frozen=True)
class Scene:
    """What all solve.

    Attributes:
        urdf: the two arms.
        ready: the posture to keep, rad, in the model's order, shape (14,).
        hand: the link that reaches.
    """

    urdf: Path
    ready: Floats
    hand: str = "right_palm"


@dataclass(frozen=True)
class Peer:
    """A way to solve a tick.

    Attributes:
        name: with the solver, if there is a choice.
        tick: from joint positions (14,) to a displacement or velocity.
        solves: what it leaves out of the three objectives, or how it ranks them.
        prepare: makes of joint positions what ``tick`` takes, before the clock runs.
    """

    name: str
    tick: Callable[[Any], object]
    solves: str
    prepare: Callable[[Floats], Any] = np.copy


@contextmanager
def two_arms() -> Iterator[Path]:
    """A folder with the documents, and Dexter's model with all joints fixed but the arms'."""
    tree = ElementTree.parse(ROOT / "robots" / "dexter.urdf")
    for joint in tree.getroot().iter("joint"):
        if "arm" not in joint.attrib["name"]:
            joint.attrib["type"] = "fixed"
            for mimic in joint.findall("mimic"):
                joint.remove(mimic)
    with tempfile.TemporaryDirectory() as folder:
        for document in DOCUMENTS.glob("*.yaml"):
            (Path(folder) / document.name).write_text(document.read_text("utf-8"), "utf-8")
        tree.write(Path(folder) / "two_arms.urdf")
        yield Path(folder)


class Ours:
    """The control path of a program, from joint positions to joint references.

    Args:
        folder: of the documents.
    """

    def __init__(self, folder: Path) -> None:
        library = Library(folder)
        self.robot = library.read(folder / "two_arms.yaml", RobotDocument).document
        program = check_program(str(folder / "three_objectives.yaml"), {}, library)
        self.kinematics = Kinematics(self.robot, folder / "two_arms.urdf")
        self._signals = Signals(self.robot, self.kinematics, ())
        self._still = np.zeros(len(self._signals.joints))
        run = ProgramRun(program, self._signals, PERIOD)
        run.begin(np.random.default_rng(0), lambda transition: None)
        self._actuation = Actuation(self.robot, self._signals, PERIOD)
        self._actuation.reset(self._still)
        self._signals.update(Observation(0.0, self._still, self._still, {}, {}))
        run.activate()
        self._active = run.active()
        self.ready = np.concatenate(
            [effector.postures["ready"] for effector in self.robot.effectors.values()]
        )

    def tick(self, q: Floats) -> Floats:
        """Everything from joint positions to joint references."""
        self._actuation.reference = q
        self._signals.update(Observation(0.0, q, self._still, {}, {}))
        self._actuation.move(self._active)
        return self._actuation.reference


def pink(scene: Scene) -> Iterator[Peer]:
    """Weighted tasks in one quadratic program."""
    import pinocchio  # noqa: TID251 -- as Pink's users do
    from pink import Configuration, solve_ik
    from pink.exceptions import NoSolutionFound
    from pink.tasks import FrameTask, ManipulabilityTask, PostureTask

    model = pinocchio.buildModelFromUrdf(str(scene.urdf))
    configuration = Configuration(model, model.createData(), scene.ready)
    reach = FrameTask(scene.hand, position_cost=1.0, orientation_cost=0.0, gain=0.1)
    reach.set_target(pinocchio.SE3(np.eye(3), GOAL))
    posture = PostureTask(cost=1e-3, gain=0.03)
    posture.set_target(scene.ready)
    dexterity = ManipulabilityTask(scene.hand, model, cost=1e-2, mask="position")
    for solver in ("daqp", "quadprog", "proxqp"):

        def tick(q: Floats, solver: str = solver) -> Any:
            configuration.update(q)
            with suppress(NoSolutionFound):
                return solve_ik(configuration, [reach, posture, dexterity], PERIOD, solver=solver)
            return None

        yield Peer(f"pink {solver}", tick, "weights")


def placo(scene: Scene) -> Iterator[Peer]:
    """Weighted tasks in one quadratic program, in C++."""
    import placo as library

    robot = library.RobotWrapper(str(scene.urdf), library.Flags.ignore_collisions)
    solver = library.KinematicsSolver(robot)
    solver.mask_fbase(True)
    solver.dt = PERIOD
    solver.enable_joint_limits(True)
    solver.enable_velocity_limits(True)
    solver.add_position_task(scene.hand, GOAL).configure("reach", "soft", 1.0)
    posture = solver.add_joints_task()
    posture.set_joints(dict(zip(robot.joint_names(), scene.ready.tolist(), strict=True)))
    posture.configure("posture", "soft", 1e-3)
    solver.add_manipulability_task(scene.hand, "position", 0.1).configure("dexterity", "soft", 1e-2)

    def tick(q: Floats) -> Any:
        robot.state.q[7:] = q
        robot.update_kinematics()
        return solver.solve(False)

    yield Peer("placo", tick, "weights")


def mink(scene: Scene) -> Iterator[Peer]:
    """Weighted tasks in one quadratic program, on MuJoCo."""
    import mink as library
    import mujoco

    text = scene.urdf.read_text("utf-8").replace(
        "</robot>",
        '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco></robot>',
    )
    model = mujoco.MjModel.from_xml_string(text)
    configuration = library.Configuration(model, scene.ready)
    reach = library.FrameTask(scene.hand, "body", position_cost=1.0, orientation_cost=0.0, gain=0.1)
    reach.set_target(library.SE3.from_translation(GOAL))
    posture = library.PostureTask(model, cost=1e-3, gain=0.03)
    posture.set_target(scene.ready)

    def tick(q: Floats) -> Any:
        configuration.update(q)
        return library.solve_ik(configuration, [reach, posture], PERIOD, "daqp")

    yield Peer("mink daqp", tick, "weights, no manipulability")


def drake(scene: Scene) -> Iterator[Peer]:
    """A reach with a posture below it, in one quadratic program."""
    from pydrake.multibody.inverse_kinematics import (
        DifferentialInverseKinematicsParameters,
        DoDifferentialInverseKinematics,
    )
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import JacobianWrtVariable

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(scene.urdf))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("torso"))
    plant.Finalize()
    context, n = plant.CreateDefaultContext(), plant.num_velocities()
    hand, world = plant.GetFrameByName(scene.hand), plant.world_frame()
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(PERIOD)
    parameters.set_nominal_joint_position(scene.ready)
    parameters.set_joint_centering_gain(2.0 * np.eye(n))
    parameters.set_joint_position_limits(
        (plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits())
    )
    parameters.set_joint_velocity_limits((np.full(n, -1.5), np.full(n, 1.5)))
    wrt, origin = JacobianWrtVariable.kV, np.zeros(3)

    def tick(q: Floats) -> Any:
        plant.SetPositions(context, q)
        rows = plant.CalcJacobianTranslationalVelocity(context, wrt, hand, origin, world, world)
        here = plant.CalcPointsPositions(context, hand, origin, world).ravel()
        return DoDifferentialInverseKinematics(
            q, np.zeros(n), 4.0 * (GOAL - here), rows, parameters
        )

    yield Peer("drake", tick, "two levels, no manipulability")


PEERS: dict[str, Callable[[Scene], Iterator[Peer]]] = {
    "pink": pink,
    "placo": placo,
    "mink": mink,
    "pydrake": drake,
}

STAGES: Stages = {
    "kinematics": [(Kinematics, "update"), (Kinematics, "point"), (Kinematics, "curvature")],
    "signals": [(Signals, "update"), (Signals, "read"), (Tips, "manipulator")],
    "levels": [(Crew, "act"), (Task, "act")],
    "law": [(Law, "advance")],
    "runtime": [(ControllerRun, "sense"), (Actuation, "move")],
}


def dexter() -> Peer:
    """The whole control cycle of Dexter: six levels, from sensors to references and predicates."""
    cycle = Cycle.of("reachtouch")
    cycle.restart()
    return Peer("cbdsl Dexter", cycle.tick, "Dexter, six levels", lambda q: cycle.following())


def installed(scene: Scene) -> tuple[list[Peer], list[str]]:
    """The peers, and the names of those that are not installed."""
    peers: list[Peer] = []
    missing = []
    for module, make in PEERS.items():
        try:
            importlib.import_module(module)
        except ImportError:
            missing.append(module)
        else:
            peers += make(scene)
    return peers, missing


def microseconds(peer: Peer, q: Floats) -> float:
    """Time of one tick."""
    prepared = peer.prepare(q)
    start = perf_counter()
    peer.tick(prepared)
    return (perf_counter() - start) * 1e6


def interleaved(
    peers: list[Peer], postures: list[Floats], rounds: int, block: int
) -> dict[str, float]:
    """Median times, us, by name; everyone, in any order, solves a block of postures."""
    times: dict[str, list[float]] = {peer.name: [] for peer in peers}
    rng = np.random.default_rng(1)
    for number in range(rounds + 1):
        for start in range(0, len(postures), block):
            for turn in rng.permutation(len(peers)):
                peer = peers[turn]
                found = [microseconds(peer, q) for q in postures[start : start + block]]
                if number:  # the first round warms up
                    times[peer.name] += found
    return {name: round(statistics.median(found), 1) for name, found in times.items()}


def table(mode: str, peers: list[Peer], medians: dict[str, float]) -> list[str]:
    """Lines of medians, also as parts of that of Pink's fastest solver, where there is one."""
    fastest = min((time for name, time in medians.items() if "pink" in name), default=math.nan)
    lines = [f"{mode}: median of a tick, and per that of Pink's fastest solver"]
    for peer in peers:
        time = medians[peer.name]
        lines.append(f"  {peer.name:16}{time:7.0f} us {time / fastest:6.2f}   {peer.solves}")
    return lines


def split(tick: Tick, postures: list[Floats], rounds: int) -> dict[str, float]:
    """Median times of our stages, us, with the clocks' own share."""
    times: dict[str, list[float]] = {stage: [] for stage in STAGES}
    with Stopwatch(STAGES) as watch:
        for q in postures * rounds:
            watch.seconds.clear()
            tick(q.copy())
            for stage, seconds in watch.seconds.items():
                times[stage].append(seconds * 1e6)
    return {stage: round(statistics.median(found), 1) for stage, found in times.items()}


def main() -> None:
    """Time everyone and print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--postures", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--block", type=int, default=20, help="ticks in a row in blocks")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    with two_arms() as folder:
        ours = Ours(folder)
        scene = Scene(folder / "two_arms.urdf", ours.ready)
        peers, missing = installed(scene)
        own = [
            Peer("cbdsl", ours.tick, "strict priorities"),
            dexter(),
        ]
        # The others refuse to start outside limits.
        lower, upper = ours.kinematics.lower + 0.05, ours.kinematics.upper - 0.05
        around = ours.ready + rng.uniform(-0.3, 0.3, (options.postures, len(ours.ready)))
        postures = list(np.clip(around, lower, upper))
        everyone = [*own, *peers]
        modes = {
            "in blocks": interleaved(everyone, postures, options.rounds, options.block),
            "in turn": interleaved(everyone, postures, options.rounds, 1),
        }
        stages = split(ours.tick, postures, options.rounds)
    if options.json:
        found = {"microseconds": modes, "split": stages, "not_installed": missing}
        sys.stdout.write(json.dumps(found) + "\n")
        return
    lines = [f"  {name} is not installed" for name in missing]
    for mode, medians in modes.items():
        lines += table(mode, everyone, medians)
    parts = ", ".join(f"{stage} {time:.0f}" for stage, time in stages.items())
    lines.append(f"cbdsl, with clocks in it: {parts} us")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
