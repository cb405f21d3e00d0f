"""Joint servos: stiffness in proportion to the moved inertia, and brakes at the largest speed."""

# Model: a servo has the torque tau = kp (r - q) - kv dq/dt, with kp = w^2 I and kv = kp * lag, for
# the natural frequency w and the moved inertia I. The reference r is clipped to the interval
#     q - taper dq/dt -+ (lag + taper) v_max
# so that at the interval's upper end
#     tau = (lag + taper) kp * (v_max - dq/dt)
# falls linearly from (lag + taper) kp v_max at rest to 0 at v_max. The taper is chosen so that the
# torque at rest is the effort, as far as this is stable. Gravity compensation is added to tau, and
# the sum stays within the effort.
# Assumption: I is that of the first posture, the diagonal of the mass matrix. A posture with more
# inertia has a lower frequency.

from __future__ import annotations

import math
from typing import Any

import mujoco as mj
import numpy as np

from cbdsl.extend.backend import Floats, Joints, RobotDocument, Rows, UrdfModel, compiled_once
from cbdsl_mujoco.first_posture import FirstPosture
from cbdsl_mujoco.world import StepArrays

# Torque per speed that an explicit step tolerates, as a share of inertia over timestep.
_STEEPEST = 0.5


class MujocoServos:
    """Servos of one natural frequency in the actuated joints, within the URDF's limits.

    The torque of a servo is kp (reference - q) - kv dq/dt plus gravity compensation. kp is the
    inertia that the joint moves times the squared frequency, and kv is kp times the servos' lag.
    All joints, coupled ones included, get an additional share of that inertia, like a gear's rotor.
    A reference is kept so near that the torque falls linearly with the speed. The line leads from
    the effort at rest to the torque that keeps the largest speed. Rotors are at least so heavy that
    this line is stable: a gripper with light, slow fingers pushes as hard as its drive can. Beyond
    the largest speed a joint is braked.

    Args:
        spec: Specification of the robot, to which the servos are added.
        robot: Robot document, which names the joints.
        model: URDF model of the robot.
        first: Posture in which the inertias are taken.
    """

    def __init__(
        self, spec: Any, robot: RobotDocument, model: UrdfModel, first: FirstPosture
    ) -> None:
        joints, settings = Joints(robot), robot.simulation.mujoco
        timestep = spec.option.timestep
        # A servo that closes the share g of its error in each step, as on Bullet, lags by dt / g.
        lag = timestep / max(robot.simulation.position_gain, 1e-9)
        moved = _inertias(first, joints)
        limits = [model.joints[name] for name in joints.names]
        fastest = np.array([joint.velocity for joint in limits])
        efforts = [_effort(robot, model, name) for name in joints.names]
        rotors = settings.armature * moved
        # Steepest stable fall of the torque over the speed, per inertia.
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
        # Fall of the torque per speed, besides the servo's own damping. Without a largest speed it
        # does not fall, for any effort.
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
        """Set the references of the servos, and brake joints that are too fast.

        Args:
            arrays: Output: references and damping.
            rows: Rows of the actuated joints among all positions and velocities, shape (n,) each.
            targets: Targets, rad or m, shape (n,).
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
    """Set references and damping; see ``MujocoServos.drive``.

    ``limits`` has seven rows: lower and upper positions, largest velocities, farthest references at
    rest, their decrease per speed, inertias over the timestep, and efforts. In one implicit step, a
    brake alone takes a joint as far below its largest velocity as it was above it.
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
            # An implicit step divides the speed v by 1 + d dt / I. With d = 2 (I / dt) (v / v_max -
            # 1), a small relative excess e over v_max becomes -e. The damping may exert no more
            # than the effort.
            needed = 2.0 * impulses[joint] * (speed / fastest[joint] - 1.0)
            damping[row] = min(needed, efforts[joint] / speed)


def _effort(robot: RobotDocument, model: UrdfModel, name: str) -> float:
    """Return the smaller of the efforts in robot file and URDF, N m or N."""
    return min(robot.simulation.efforts.get(name, math.inf), model.joints[name].effort)


def _limit(joint: Any, effort: float) -> None:
    joint.actgravcomp = True
    if math.isfinite(effort):
        joint.actfrclimited = mj.mjtLimited.mjLIMITED_TRUE
        joint.actfrcrange = [-effort, effort]


def _inertias(first: FirstPosture, joints: Joints) -> Floats:
    """Return inertias moved by joints in the first posture, kg m^2 or kg, shape (all joints,)."""
    compiled = first.compiled
    full = np.zeros((compiled.nv, compiled.nv))
    mj.mj_fullM(compiled, first.data, full)
    inertias: Floats = np.diag(full)[[int(compiled.joint(name).dofadr[0]) for name in joints.all]]
    return inertias
