"""MuJoCo specification of the robot, from its URDF and its robot file."""

from __future__ import annotations

import math
from typing import Any

import mujoco as mj

from cbdsl.extend.backend import (
    GRAVITY,
    BackendError,
    Coupling,
    Joints,
    LinkMass,
    MujocoSection,
    Pose,
    RobotDocument,
    UrdfJoint,
    UrdfModel,
    displacement,
    link_masses,
    link_surfaces,
    pairs_without_contact,
)
from cbdsl_mujoco.contact import ContactSettings
from cbdsl_mujoco.geometry import add_shape

# Friction of links without a surface in the robot file.
_FRICTION = 0.5
_JOINTS = {
    "revolute": mj.mjtJoint.mjJNT_HINGE,
    "continuous": mj.mjtJoint.mjJNT_HINGE,
    "prismatic": mj.mjtJoint.mjJNT_SLIDE,
}


def make_robot_spec(robot: RobotDocument, model: UrdfModel, timestep: float) -> Any:
    """Return a robot in an otherwise empty world, without servos and sensors.

    A joint that the robot file does not name rests, as near to 0 as its limits allow. Coupled
    joints follow their leading joints by an equality constraint.

    Args:
        robot: Robot document, which names joints and surfaces.
        model: URDF model of the robot.
        timestep: Period of a physics step, s.

    Raises:
        BackendError: The model has a shape that MuJoCo cannot simulate, or lacks a link that the
            robot file names.
    """
    settings = robot.simulation.mujoco
    spec = _empty_world(timestep, settings)
    _Links(spec, robot, model)
    for first, second in sorted(pairs_without_contact(robot, model) | model.carried_pairs()):
        spec.add_exclude(bodyname1=body_name(first), bodyname2=body_name(second))
    for passive, coupling in robot.couplings.items():
        _couple(spec, passive, coupling)
    return spec


def compile_spec(spec: Any, model: UrdfModel) -> Any:
    """Return MuJoCo's model of a specification.

    Raises:
        BackendError: The specification cannot be simulated.
    """
    try:
        return spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise BackendError(f"the simulator cannot read the model {model.path}: {reason}") from error


def _empty_world(timestep: float, settings: MujocoSection) -> Any:
    spec = mj.MjSpec()
    compiler, option = spec.compiler, spec.option
    compiler.degree = False
    # Removes the rounding of moments that are just possible.
    compiler.balanceinertia = True
    option.timestep, option.gravity = timestep, [0.0, 0.0, -GRAVITY]
    # Damping is integrated implicitly, so that the servos' brakes are stable.
    option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mj.mjtCone.mjCONE_ELLIPTIC
    option.impratio = settings.friction_stiffness
    option.noslip_iterations = settings.noslip_iterations
    light = spec.visual.headlight
    light.ambient, light.diffuse = [0.4] * 3, [0.6] * 3
    return spec


class _Links:
    """Bodies of all links in a specification."""

    def __init__(self, spec: Any, robot: RobotDocument, model: UrdfModel) -> None:
        self._spec, self._model, self._joints = spec, model, Joints(robot)
        self._contact = ContactSettings(robot.simulation.mujoco)
        self._masses = link_masses(model)
        self._friction = {
            link: surface.friction for link, surface in link_surfaces(robot, model).items()
        }
        below: dict[str, list[UrdfJoint]] = {}
        for joint in model.joints.values():
            below.setdefault(joint.parent, []).append(joint)
        waiting = [(robot.base, spec.worldbody.add_body(name=body_name(robot.base)))]
        while waiting:
            link, body = waiting.pop()
            self._fill(body, link)
            joints = reversed(below.get(link, []))
            waiting.extend((joint.child, self._hang(body, joint)) for joint in joints)

    def _hang(self, parent: Any, joint: UrdfJoint) -> Any:
        """Return a new body that hangs on a joint."""
        is_driven = joint.name in self._joints.index
        pose = Pose.at(joint.origin)
        # A joint that the robot file does not name is welded at its rest position.
        if joint.movable and not is_driven:
            pose = pose @ displacement(joint, self._model.rests[joint.name])
        name = body_name(joint.child)
        child = parent.add_body(name=name, pos=pose.position, quat=wxyz(pose))
        if is_driven:
            moved = child.add_joint(name=joint.name, type=_JOINTS[joint.kind], axis=joint.axis)
            moved.limited = mj.mjtLimited.mjLIMITED_FALSE
            if math.isfinite(joint.upper - joint.lower):
                moved.limited = mj.mjtLimited.mjLIMITED_TRUE
                moved.range = [joint.lower, joint.upper]
        return child

    def _fill(self, body: Any, link: str) -> None:
        """Set mass and shapes of a link's body."""
        content = self._model.bodies[link]
        # Weights are compensated by the servos, as their part of the effort; see ``servos._limit``.
        body.gravcomp = 1.0
        _set_mass(body, self._masses[link])
        for number, shape in enumerate(content.collisions):
            geom = add_shape(self._spec, body, shape, f"{link}/{number}", self._model.path)
            self._contact.apply(geom, self._friction.get(link, _FRICTION))


def body_name(link: str) -> str:
    """Return the name of a link's body, distinct from MuJoCo's fixed body ``world``."""
    return f"link/{link}"


def wxyz(pose: Pose) -> tuple[float, float, float, float]:
    """Return a rotation as MuJoCo's quaternion."""
    x, y, z, w = pose.quaternion()
    return w, x, y, z


def _set_mass(body: Any, of: LinkMass) -> None:
    # Otherwise MuJoCo would compute the mass from the shapes.
    body.explicitinertial = True
    body.mass, body.inertia = of.mass, of.moments
    body.ipos, body.iquat = of.frame.position, wxyz(of.frame)


def _couple(spec: Any, passive: str, coupling: Coupling) -> None:
    """Couple a joint to its leading joint, as stiffly as the timestep allows."""
    equality = spec.add_equality(
        type=mj.mjtEq.mjEQ_JOINT,
        objtype=mj.mjtObj.mjOBJ_JOINT,
        name1=passive,
        name2=coupling.follows,
    )
    # Coefficients of a polynomial of the fourth degree in the leading joint's position.
    equality.data[:5] = [coupling.offset, coupling.ratio, 0.0, 0.0, 0.0]
    # MuJoCo keeps time constants at two timesteps or above.
    equality.solref = [2 * spec.option.timestep, 1.0]
    equality.solimp = [0.99, 0.999, 0.001, 0.5, 2.0]
