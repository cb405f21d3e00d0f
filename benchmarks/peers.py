"""Other libraries' inverse kinematics of the scene that ``control_peers.py`` times.

Needs numpy and the library alone, so that a library with requirements of its own runs in an
environment of its own (``peer_process.py``).
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cbdsl.numeric.arrays import Floats

GOAL = np.array([0.45, -0.3, 0.2])  # m
PERIOD = 1 / 60  # s


@dataclass(frozen=True)
class Scene:
    """The task that all solve.

    Attributes:
        urdf: Model of the two arms.
        ready: Posture to keep, rad, in the model's order, shape (14,).
        hand: Name of the reaching link.
    """

    urdf: Path
    ready: Floats
    hand: str = "right_palm"


@dataclass(frozen=True)
class Peer:
    """Way to solve a tick.

    Attributes:
        name: Name of the library, with the solver, if there is a choice.
        tick: Function from joint positions (14,) to a displacement or velocity.
        solves: Objectives that it leaves out, or their ranking.
        prepare: Function that converts joint positions for ``tick``, before the clock runs.
    """

    name: str
    tick: Callable[[Any], object]
    solves: str
    prepare: Callable[[Floats], Any] = np.copy

    def times(self, postures: Sequence[Floats]) -> list[float]:
        """Return times of a tick for each posture, us."""
        times = []
        for q in postures:
            prepared = self.prepare(q)
            start = perf_counter()
            self.tick(prepared)
            times.append((perf_counter() - start) * 1e6)
        return times


def pink(scene: Scene) -> Iterator[Peer]:
    """Yield weighted tasks in one quadratic program."""
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
        # The default argument binds the solver of this iteration, and not that of the last one.
        def tick(q: Floats, solver: str = solver) -> Any:
            configuration.update(q)
            with suppress(NoSolutionFound):
                return solve_ik(configuration, [reach, posture, dexterity], PERIOD, solver=solver)
            return None

        yield Peer(f"pink {solver}", tick, "weights")


def placo(scene: Scene) -> Iterator[Peer]:
    """Yield weighted tasks in one quadratic program, in C++."""
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
        # The first seven coordinates are the pose of the floating base, which the solver masks.
        robot.state.q[7:] = q
        robot.update_kinematics()
        return solver.solve(False)

    yield Peer("placo", tick, "weights")


def mink(scene: Scene) -> Iterator[Peer]:
    """Yield weighted tasks in one quadratic program, on MuJoCo."""
    import mink as library
    import mujoco  # noqa: TID251 -- as Mink's users do

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
    """Yield a reach with a posture below it, in one quadratic program."""
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


def load(module: str, scene: Scene) -> list[Peer]:
    """Return the peers of a library.

    Raises:
        ImportError: It cannot be imported here.
    """
    importlib.import_module(module)
    return list(PEERS[module](scene))
