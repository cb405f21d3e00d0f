"""Joint servos: their stiffness goes with the inertia that a joint moves, brakes keep its speed."""

from __future__ import annotations

import math
from typing import Any

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.mujoco.first_posture import FirstPosture
from cbdsl.backends.mujoco.world import StepArrays
from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.compiled import compiled_once
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

# Torque per speed that an explicit step bears, as a share of the inertia over the timestep.
_STEEPEST = 0.5


class MujocoServos:
    """Servos of one natural frequency in the actuated joints, within the URDF's limits.

    The torque of a servo is kp (reference - q) - kv dq/dt, and what gravity takes; kp is the
    inertia that the joint moves times the frequency squared, kv is kp times the servos' lag. All
    joints, coupled ones too, are given a share of that inertia besides, as of a gearing's rotor.
    A reference is kept so near that the torque falls along a line: from the effort at rest to that
    which keeps the largest speed. Rotors are at least so heavy that this line is stable: a gripper
    whose light fingers are slow pushes as hard as its drive can. Beyond the largest speed a joint
    is braked.

    Args:
        spec: of the robot, without servos; takes them.
        robot: names the joints.
        model: its URDF.
        first: posture, in which the inertias are taken.
    """

    def __init__(
        self, spec: Any, robot: RobotDocument, model: UrdfModel, first: FirstPosture
    ) -> None:
        joints, settings = Joints(robot), robot.simulation.mujoco
        timestep = spec.option.timestep
        lag = timestep / max(robot.simulation.position_gain, 1e-9)
        moved = _inertias(first, joints)
        limits = [model.joints[name] for name in joints.names]
        fastest = np.array([joint.velocity for joint in limits])
        efforts = [_effort(robot, model, name) for name in joints.names]
        rotors = settings.armature * moved
        # The steepest stable fall of the torque over the speed, per inertia.
        steepest = _STEEPEST / timestep + settings.servo_frequency**2 * lag
        least = np.where(np.isfinite(efforts), efforts, 0.0) / (fastest * steepest)
        own = slice(len(joints.names))
        rotors[own] = np.maximum(rotors[own], least - moved[own])
        for name, rotor in zip(joints.all, rotors.tolist(), strict=True):
            spec.joint(name).armature = rotor
        inertias = (moved + rotors)[own]
        for name, inertia, effort in zip(joints.names, inertias.tolist(), efforts, strict=True):
            stiffness = settings.servo_frequency**2 * inertia
            servo = spec.add_actuator(name=name, target=name, trntype=mj.mjtTrn.mjTRN_JOINT)
            servo.set_to_position(stiffness, stiffness * lag)
            _limit(spec.joint(name), effort)
        stiffness = settings.servo_frequency**2 * inertias
        impulses = inertias / timestep
        # How much the torque may fall with the speed, besides the servo's own damping.
        # Without a largest speed it does not fall, however large the effort is.
        steepness = np.zeros(len(fastest))
        np.divide(efforts, fastest, out=steepness, where=np.isfinite(fastest))
        falls = steepness - stiffness * lag
        tapers = np.clip(falls, 0.0, _STEEPEST * impulses) / stiffness
        self._limits = np.array(
            [
                [joint.lower for joint in limits],
                [joint.upper for joint in limits],
                fastest,
                (lag + tapers) * fastest,
                tapers,
                impulses,
                efforts,
            ]
        )

    def drive(self, arrays: StepArrays, rows: tuple[Rows, Rows], targets: Floats) -> None:
        """Give the servos their references, and brake.

        Args:
            arrays: take references and damping.
            rows: of the actuated joints among all positions and velocities, shape (n,) each.
            targets: rad or m, shape (n,).
        """
        state = arrays.positions, arrays.velocities
        _drive(*state, *rows, targets, self._limits, arrays.references, arrays.damping)


@compiled_once
def _drive(
    positions: Floats,
    velocities: Floats,
    places: Rows,
    rows: Rows,
    targets: Floats,
    limits: Floats,
    references: Floats,
    damping: Floats,
) -> None:
    """See ``MujocoServos.drive``; ``limits`` has seven rows.

    Lower and upper positions, largest velocities, farthest references at rest, by how much nearer
    they are per speed, inertias over the timestep, and efforts. In one implicit step, a brake takes
    a joint by itself below its largest velocity by as much as it was above it.
    """
    lower, upper, fastest, farthest, tapers, impulses, efforts = limits
    for joint in range(len(targets)):
        place, row = places[joint], rows[joint]
        speed = abs(velocities[row])
        middle = positions[place] - tapers[joint] * velocities[row]
        reference = min(max(targets[joint], lower[joint]), upper[joint])
        least, most = middle - farthest[joint], middle + farthest[joint]
        references[joint] = min(max(reference, least), most)
        damping[row] = 0.0
        if speed > fastest[joint]:
            needed = 2.0 * impulses[joint] * (speed / fastest[joint] - 1.0)
            damping[row] = min(needed, efforts[joint] / speed)


def _effort(robot: RobotDocument, model: UrdfModel, name: str) -> float:
    """The smaller of the robot file's and the URDF's, N m or N."""
    return min(robot.simulation.efforts.get(name, math.inf), model.joints[name].effort)


def _limit(joint: Any, effort: float) -> None:
    joint.actgravcomp = True
    if math.isfinite(effort):
        joint.actfrclimited = mj.mjtLimited.mjLIMITED_TRUE
        joint.actfrcrange = [-effort, effort]


def _inertias(first: FirstPosture, joints: Joints) -> Floats:
    """Inertia that each joint moves in the first posture, kg m^2 or kg, shape (all joints,)."""
    compiled = first.compiled
    full = np.zeros((compiled.nv, compiled.nv))
    mj.mj_fullM(compiled, first.data, full)
    inertias: Floats = np.diag(full)[[int(compiled.joint(name).dofadr[0]) for name in joints.all]]
    return inertias
