"""World in one episode: a specification, MuJoCo's compiled model, and its state."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import mujoco as mj

from cbdsl.extend.backend import Floats, RobotDocument, SceneObject, UrdfModel, link_surfaces
from cbdsl_mujoco.contact import ContactSettings
from cbdsl_mujoco.geometry import add_solids
from cbdsl_mujoco.robot_spec import body_name, compile_spec, wxyz

# Number of values of a free body's position and of its velocity.
_POSE, _TWIST = 7, 6


class Body(NamedTuple):
    """Addresses of an object in MuJoCo.

    Attributes:
        number: Number of the object's body.
        pose: First index of its position and quaternion among all positions; -1 for a fixture.
        twist: First index of its velocities among all velocities; -1 for a fixture.
        grip: Number of the constraint by which the experimenter holds it; -1 for a fixture.
    """

    number: int
    pose: int = -1
    twist: int = -1
    grip: int = -1


class StepArrays(NamedTuple):
    """Arrays that a step reads and writes, in MuJoCo's own memory.

    Every access to an array of MuJoCo makes another view, which takes as long as a small kernel.

    Attributes:
        positions, velocities: Positions and velocities of all joints and free bodies.
        references: References of the servos.
        damping: Damping of all velocities, N m s/rad or N s/m.
        readings: Readings of all sensors.
        origins: Origins of all bodies, m, shape (bodies, 3).
    """

    positions: Floats
    velocities: Floats
    references: Floats
    damping: Floats
    readings: Floats
    origins: Floats

    @classmethod
    def of(cls, model: Any, data: Any) -> StepArrays:
        """Return the arrays of a model and its state."""
        forces = model.dof_damping, data.sensordata
        return cls(data.qpos, data.qvel, data.ctrl, *forces, data.xpos)


class MujocoWorld:
    """Robot and objects that are added and removed.

    A change of the objects requires another model, which is compiled at its next use: simultaneous
    changes cost one compilation.

    Args:
        spec: Specification of the robot.
        robot: Robot document, with surfaces and contact constants.
        urdf: URDF model of the robot.
    """

    def __init__(self, spec: Any, robot: RobotDocument, urdf: UrdfModel) -> None:
        self._robot, self._urdf = spec, urdf
        self._contact = ContactSettings(robot.simulation.mujoco)
        self._grip_time = 2 * spec.option.timestep
        self.bare = compile_spec(spec.copy(), urdf)
        self._soft = tuple(soft_shapes(robot, urdf, self.bare))
        self.begin()

    def begin(self) -> None:
        """Remove everything but the robot from the world."""
        self._spec: Any = None
        self._model, self._data = self.bare, mj.MjData(self.bare)
        self._arrays = StepArrays.of(self._model, self._data)
        self._bodies: dict[str, Body] = {}
        self._names: list[str] = []
        self._pairs: dict[str, list[Any]] = {}
        self._stale = False

    def add(self, item: SceneObject) -> None:
        """Add an object to the world; without mass it does not move."""
        spec, name = self._changed(), _named(item.name)
        self._names.append(item.name)
        position, quaternion = item.pose.position, wxyz(item.pose)
        body = spec.worldbody.add_body(name=name, pos=position, quat=quaternion)
        movable = item.mass > 0
        # The mobility against a push through the centre; rotation is neglected.
        mobility = 1 / item.mass if movable else 0.0
        self._pairs[item.name] = []
        for number, geom in enumerate(add_solids(spec, body, item.shape, item.mass)):
            geom.name = f"{name}/{number}"
            geom.condim, geom.rgba = 6, [*item.surface.color, 1.0]
            self._contact.apply_surface(geom, item.surface, movable=movable)
            self._pairs[item.name] += [
                shape.press(spec, geom, mobility, movable) for shape in self._soft
            ]
        if movable:
            body.add_freejoint(name=name)
            grip = spec.add_equality(
                name=name,
                type=mj.mjtEq.mjEQ_WELD,
                objtype=mj.mjtObj.mjOBJ_BODY,
                name1="world",
                name2=name,
                active=False,
            )
            grip.solref = [self._grip_time, 1.0]

    def remove(self, name: str) -> None:
        """Remove an object from the world."""
        spec, own = self._changed(), _named(name)
        self._names.remove(name)
        for pair in self._pairs.pop(name):
            spec.delete(pair)
        grip = spec.equality(own)
        if grip is not None:
            spec.delete(grip)
        spec.delete(spec.body(own))

    def _changed(self) -> Any:
        if self._spec is None:
            self._spec = self._robot.copy()
        self._stale = True
        return self._spec

    def current(self) -> tuple[Any, Any, StepArrays]:
        """Return the current model, its state, and the arrays of a step."""
        if self._stale:
            self._update()
        return self._model, self._data, self._arrays

    @property
    def model(self) -> Any:
        """MuJoCo's model of the current world."""
        return self.current()[0]

    @property
    def data(self) -> Any:
        """State of the current world."""
        return self.current()[1]

    def body(self, name: str) -> Body:
        """Return the addresses of an object."""
        self.current()
        return self._bodies[name]

    def _update(self) -> None:
        """Compile the changes, and transfer the state."""
        self._stale = False
        model, data, bodies = self._model, self._data, self._bodies
        self._model = compile_spec(self._spec, self._urdf)
        self._data = mj.MjData(self._model)
        self._arrays = StepArrays.of(self._model, self._data)
        self._bodies = {name: self._located(name) for name in self._names}
        # The robot's joints precede all objects in each model, so that its indices never change.
        self._data.time, self._data.ctrl[:] = data.time, data.ctrl
        self._take_over(data, (0, 0, self.bare.nq), (0, 0, self.bare.nv))
        for name in bodies.keys() & self._bodies.keys():
            old, new = bodies[name], self._bodies[name]
            # A fixture has no state.
            if old.grip >= 0:
                self._take_over(data, (old.pose, new.pose, _POSE), (old.twist, new.twist, _TWIST))
                self._data.eq_active[new.grip] = data.eq_active[old.grip]
                self._model.eq_data[new.grip] = model.eq_data[old.grip]

    def _located(self, name: str) -> Body:
        model, own = self._model, _named(name)
        number = int(model.body(own).id)
        if not model.body_dofnum[number]:
            return Body(number)
        joint = model.joint(own)
        grip = mj.mj_name2id(model, mj.mjtObj.mjOBJ_EQUALITY, own)
        return Body(number, int(joint.qposadr[0]), int(joint.dofadr[0]), grip)

    def _take_over(
        self, data: Any, positions: tuple[int, int, int], velocities: tuple[int, int, int]
    ) -> None:
        """Transfer a part of the state: old index, new index, and count."""
        begin, own, count = positions
        self._data.qpos[own : own + count] = data.qpos[begin : begin + count]
        begin, own, count = velocities
        # The solver starts from the last accelerations, so that they are a part of the state.
        for kind in ("qvel", "qacc_warmstart"):
            stretch = getattr(data, kind)[begin : begin + count]
            getattr(self._data, kind)[own : own + count] = stretch


def _named(name: str) -> str:
    """Return an object's name, distinct from those of links and joints."""
    return f"object/{name}"


# Bounds of the impedances with which the solver is stable.
_SOFTEST, _STIFFEST = 0.2, 0.99
# Width, middle and power of an impedance that does not change with depth.
_SHAPE = [0.001, 0.5, 2.0]


class SoftShape(NamedTuple):
    """Shape of the robot whose surface has a stiffness and a damping.

    Attributes:
        geom: Name of the shape in the specification.
        friction: Coefficient of lateral friction.
        stiffness: Stiffness, N/m.
        damping: Damping, N s/m.
        mobility: Mobility of the link, 1/kg: inverse of its inertia against a push.
    """

    geom: str
    friction: float
    stiffness: float
    damping: float
    mobility: float

    def press(self, spec: Any, geom: Any, mobility: float, movable: bool) -> Any:
        """Add the contact pair of this soft shape with a shape of an object; return the pair.

        MuJoCo pushes two bodies apart with the force impedance / (1 - impedance) / mobility times
        the acceleration of a critically damped spring (its documentation, "Solver parameters").
        So the stiffness is 1 / ((1 - impedance) mobility time^2), and the damping is twice the
        stiffness times the time constant.

        Args:
            spec: Specification of the world.
            geom: Shape of the object.
            mobility: Mobility of the object, 1/kg.
            movable: True if the object's friction counts.
        """
        # Two unknowns, impedance and time, follow from two equations, stiffness and damping. The
        # damping gives the time, and the stiffness then gives the impedance.
        together = max(self.mobility + mobility, 1e-9)
        time = max(self.damping / (2.0 * self.stiffness), 2.0 * spec.option.timestep)
        impedance = 1.0 - 1.0 / (self.stiffness * together * time**2)
        # The time is too short for the stiffness, for example with little damping. The stiffness is
        # kept, and the damping becomes larger than requested.
        if impedance < _SOFTEST:
            impedance = _SOFTEST
            time = math.sqrt(1.0 / ((1.0 - impedance) * self.stiffness * together))
        impedance = min(impedance, _STIFFEST)
        friction, spinning, rolling = geom.friction
        sliding = friction if movable else max(friction, self.friction)
        return spec.add_pair(
            geomname1=self.geom,
            geomname2=geom.name,
            condim=geom.condim,
            friction=[sliding, sliding, spinning, rolling, rolling],
            solref=[time, 1.0],
            solimp=[impedance, impedance, *_SHAPE],
        )


def soft_shapes(robot: RobotDocument, model: UrdfModel, compiled: Any) -> Iterator[SoftShape]:
    """Yield the shapes of links whose surfaces have a stiffness in the robot file.

    Args:
        robot: Robot document, which names surfaces.
        model: URDF model of the robot.
        compiled: MuJoCo's model of the robot.
    """
    for link, surface in link_surfaces(robot, model).items():
        if surface.stiffness is None:
            continue
        body = compiled.body(body_name(link))
        mobility = float(compiled.body_invweight0[body.id][0])
        first = int(body.geomadr[0])
        for number in range(first, first + int(body.geomnum[0])):
            yield SoftShape(
                compiled.geom(number).name,
                surface.friction,
                surface.stiffness,
                surface.damping or 0.0,
                mobility,
            )
