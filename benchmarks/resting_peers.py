"""Other libraries' inverse kinematics at a target that a planar arm cannot reach.

The arm of three joints has the links of ``LINKS``, and the target lies beyond its reach. Position
comes before orientation before posture, by weights of 1, 0.03 and 0.001 where a library has no
priorities. Joints integrate the displacements at 60 Hz for 15 s.

Needs numpy and the library alone, so that a library with requirements of its own runs in an
environment of its own: ``python resting_peers.py LIBRARY`` prints one JSON object.
"""

from __future__ import annotations

import importlib
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
from peers import PERIOD

from cbdsl.numeric.arrays import Floats

LINKS = (0.3, 0.25, 0.2)  # m
TARGET = np.array([0.9, 0.4, 0.0])  # m
TURN = math.radians(30.0)
START = np.array([0.3, 0.4, 0.2])  # rad
SPEED = 1.5  # rad/s
TICKS = 900
GAIN = 8.0  # 1/s

#: A function from joint positions (3,) to a displacement (3,).
Tick = Callable[[Floats], Floats]

_TURN = np.array(
    [
        [math.cos(TURN), -math.sin(TURN), 0.0],
        [math.sin(TURN), math.cos(TURN), 0.0],
        [0.0, 0.0, 1.0],
    ]
)


def urdf() -> str:
    """Return the model of the arm."""
    inertia = (
        '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
        'ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    names = ["base", "one", "two", "three"]
    parts = [f'<link name="{name}">{inertia}</link>' for name in names]
    parts.append(f'<link name="tip">{inertia}</link>')
    for number, name in enumerate(names[1:]):
        along = LINKS[number - 1] if number else 0.0
        parts.append(
            f'<joint name="joint_{name}" type="revolute"><parent link="{names[number]}"/>'
            f'<child link="{name}"/><origin xyz="{along} 0 0"/><axis xyz="0 0 1"/>'
            f'<limit lower="-3" upper="3" effort="100" velocity="{SPEED}"/></joint>'
        )
    parts.append(
        f'<joint name="end" type="fixed"><parent link="three"/><child link="tip"/>'
        f'<origin xyz="{LINKS[-1]} 0 0"/></joint>'
    )
    return f'<robot name="arm">{"".join(parts)}</robot>'


def pink(path: Path) -> Iterator[tuple[str, Tick]]:
    """Yield weighted tasks in one quadratic program, for each solver."""
    import pinocchio  # noqa: TID251 -- as Pink's users do
    from pink import Configuration, solve_ik
    from pink.exceptions import NoSolutionFound
    from pink.tasks import FrameTask, PostureTask

    model = pinocchio.buildModelFromUrdf(str(path))
    configuration = Configuration(model, model.createData(), START)
    reach = FrameTask("tip", position_cost=1.0, orientation_cost=0.03, gain=GAIN * PERIOD / 2)
    reach.set_target(pinocchio.SE3(_TURN, TARGET))
    posture = PostureTask(cost=1e-3, gain=GAIN * PERIOD / 2)
    posture.set_target(np.zeros(3))
    for solver in ("daqp", "quadprog"):

        def tick(q: Floats, solver: str = solver) -> Floats:
            configuration.update(q)
            with suppress(NoSolutionFound):
                change: Floats = PERIOD * solve_ik(
                    configuration, [reach, posture], PERIOD, solver=solver
                )
                return change
            return np.zeros(3)

        yield f"pink {solver}", tick


def mink(path: Path) -> Iterator[tuple[str, Tick]]:
    """Yield weighted tasks in one quadratic program, on MuJoCo."""
    import mink as library
    import mujoco  # noqa: TID251 -- as Mink's users do

    # MuJoCo would otherwise merge the tip into the last moving link, because their joint is fixed.
    text = path.read_text("utf-8").replace(
        "</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
    )
    model = mujoco.MjModel.from_xml_string(text)
    configuration = library.Configuration(model, START)
    reach = library.FrameTask(
        "tip", "body", position_cost=1.0, orientation_cost=0.03, gain=GAIN * PERIOD / 2
    )
    rotation = library.SO3.from_matrix(_TURN)
    reach.set_target(library.SE3.from_rotation_and_translation(rotation, TARGET))
    posture = library.PostureTask(model, cost=1e-3, gain=GAIN * PERIOD / 2)
    posture.set_target(np.zeros(3))
    names = [model.joint(number).name for number in range(model.njnt)]
    limits = [
        library.ConfigurationLimit(model),
        library.VelocityLimit(model, dict.fromkeys(names, SPEED)),
    ]

    def tick(q: Floats) -> Floats:
        configuration.update(q)
        change: Floats = PERIOD * library.solve_ik(
            configuration, [reach, posture], PERIOD, "daqp", limits=limits
        )
        return change

    yield "mink daqp", tick


def placo(path: Path) -> Iterator[tuple[str, Tick]]:
    """Yield weighted tasks in one quadratic program, in C++."""
    import placo as library

    robot = library.RobotWrapper(str(path), library.Flags.ignore_collisions)
    solver = library.KinematicsSolver(robot)
    solver.mask_fbase(True)
    solver.dt = PERIOD
    solver.enable_joint_limits(True)
    solver.enable_velocity_limits(True)
    solver.add_position_task("tip", TARGET).configure("reach", "soft", 1.0)
    solver.add_orientation_task("tip", _TURN).configure("turn", "soft", 1e-3)
    posture = solver.add_joints_task()
    posture.set_joints(dict.fromkeys(robot.joint_names(), 0.0))
    posture.configure("posture", "soft", 1e-6)

    def tick(q: Floats) -> Floats:
        # The first seven coordinates are the pose of the floating base, which the solver masks.
        robot.state.q[7:] = q
        robot.update_kinematics()
        return np.array(solver.solve(False))[-3:]

    yield "placo", tick


def drake(path: Path) -> Iterator[tuple[str, Tick]]:
    """Yield a reach with a posture below it, in one quadratic program."""
    from pydrake.multibody.inverse_kinematics import (
        DifferentialInverseKinematicsParameters,
        DoDifferentialInverseKinematics,
    )
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import JacobianWrtVariable

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(path))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    context, tip = plant.CreateDefaultContext(), plant.GetFrameByName("tip")
    world = plant.world_frame()
    parameters = DifferentialInverseKinematicsParameters(3, 3)
    parameters.set_time_step(PERIOD)
    parameters.set_nominal_joint_position(np.zeros(3))
    parameters.set_joint_centering_gain(0.5 * GAIN * np.eye(3))
    parameters.set_joint_velocity_limits((np.full(3, -SPEED), np.full(3, SPEED)))
    origin = np.zeros(3)

    def tick(q: Floats) -> Floats:
        plant.SetPositions(context, q)
        rows = plant.CalcJacobianTranslationalVelocity(
            context, JacobianWrtVariable.kV, tip, origin, world, world
        )[:2]
        here = plant.CalcPointsPositions(context, tip, origin, world).ravel()
        way = 0.5 * GAIN * (TARGET - here)[:2]
        result = DoDifferentialInverseKinematics(q, np.zeros(3), way, rows, parameters)
        velocity = result.joint_velocities
        return np.zeros(3) if velocity is None else PERIOD * np.array(velocity)

    yield "drake, no orientation", tick


PEERS: dict[str, Callable[[Path], Iterator[tuple[str, Tick]]]] = {
    "pink": pink,
    "mink": mink,
    "placo": placo,
    "pydrake": drake,
}


def settle(tick: Tick) -> dict[str, float]:
    """Return the distance beyond the least possible one, mm, and the motion at rest, deg a tick."""
    q, moves = START.copy(), []
    for _ in range(TICKS):
        moves.append(np.array(tick(q.copy())))
        q = q + moves[-1]
    angles = np.cumsum(q)
    tip = np.array([np.dot(LINKS, np.cos(angles)), np.dot(LINKS, np.sin(angles))])
    # The stretched arm comes nearest, at the distance of the target minus the length of the arm.
    beyond = np.linalg.norm(TARGET[:2] - tip) - (np.linalg.norm(TARGET) - sum(LINKS))
    last = np.degrees(np.abs(moves[-round(1 / PERIOD) :]))
    return {"beyond": round(1000 * float(beyond), 2), "motion": round(float(last.max()), 4)}


def rest_of(module: str) -> dict[str, dict[str, float]]:
    """Return the results of a library by name of its solver.

    Raises:
        ImportError: The library cannot be imported here.
    """
    importlib.import_module(module)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(urdf(), "utf-8")
        return {name: settle(tick) for name, tick in PEERS[module](path)}


def remote_rest_of(module: str, python: str) -> dict[str, dict[str, float]]:
    """Return the results of a library with the interpreter of its environment.

    Raises:
        ImportError: The library cannot be imported there.
    """
    command = [python, str(Path(__file__)), module]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode:
        raise ImportError(answer.stderr.strip().rpartition("\n")[2])
    results: dict[str, dict[str, float]] = json.loads(answer.stdout.strip().rpartition("\n")[2])
    return results


if __name__ == "__main__":
    sys.stdout.write(json.dumps(rest_of(sys.argv[1])) + "\n")
