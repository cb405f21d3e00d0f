"""MuJoCo as an engine: the robot, the objects of a stage, and their contacts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import (
    POSITION,
    ROOM,
    ROTATION,
    WIDTH,
    Cell,
    Engine,
    Floats,
    Joints,
    Pose,
    RobotDocument,
    SceneObject,
    UrdfModel,
    solid_row,
)
from cbdsl_mujoco.first_posture import FirstPosture
from cbdsl_mujoco.load_cell_sensors import (
    add_sensors,
    cell_links,
    sensor_addresses,
    sum_wrenches,
)
from cbdsl_mujoco.robot_spec import body_name, make_robot_spec, wxyz
from cbdsl_mujoco.servos import MujocoServos
from cbdsl_mujoco.window import Window
from cbdsl_mujoco.world import MujocoWorld

# Largest distance of objects that touch, m.
_TOUCHING = 1e-4


class LinkContact(NamedTuple):
    """Contact of a link of the robot.

    Attributes:
        link: Name of the link.
        other: Name of the touched object, or of another link.
        is_link: True if the other body is a link, too.
        force: Force of the link on the other body, world frame, N, shape (3,).
    """

    link: str
    other: str
    is_link: bool
    force: Floats


class MujocoEngine(Engine):
    """A robot in MuJoCo; see ``Engine``.

    Args:
        robot: Robot document.
        model: URDF model of the robot.
        timestep: Period of a physics step, s.
        window: Window to show the simulation in; ``None`` for none.

    Raises:
        BackendError: MuJoCo cannot simulate the model, or the robot file names links that the model
            does not have.
    """

    def __init__(
        self,
        robot: RobotDocument,
        model: UrdfModel,
        timestep: float,
        window: Window | None = None,
    ) -> None:
        self._joints = Joints(robot)
        spec = make_robot_spec(robot, model, timestep)
        first = FirstPosture(spec, robot, model)
        for one, other in first.overlaps():
            spec.add_exclude(bodyname1=one, bodyname2=other)
        self._servos = MujocoServos(spec, robot, model, first)
        add_sensors(spec, robot)
        self._world = MujocoWorld(spec, robot, model)
        self._window = window
        bare = self._world.bare
        # MuJoCo's first body is the world, and the robot's are next.
        self._links = slice(1, bare.nbody)
        self.rows = {link: int(bare.body(body_name(link)).id) - 1 for link in model.links}
        links = cell_links(robot)
        self.cells = tuple(links)
        self._fingertips = np.array(
            [bare.body(body_name(link)).id for link in links.values()], dtype=np.intp
        )
        self._addresses = sensor_addresses(bare, robot)
        joints = [bare.joint(name) for name in self._joints.all]
        self._positions = np.array([int(joint.qposadr[0]) for joint in joints], dtype=np.intp)
        velocities = np.array([int(joint.dofadr[0]) for joint in joints], dtype=np.intp)
        count = len(self._joints.names)
        self._rows = self._positions[:count], velocities[:count]
        self.begin(np.zeros(len(self._joints.names)))

    def begin(self, positions: Floats) -> None:
        self._world.begin()
        self.objects: dict[str, SceneObject] = {}
        self._solids: Floats = np.empty((0, WIDTH))
        self._wrenches: Floats = np.zeros((len(self.cells), 6))
        data = self._world.data
        data.qpos[self._positions] = self._joints.expand(positions)
        data.ctrl[:] = positions
        self._moved = True

    def step(self, targets: Floats) -> None:
        model, data, arrays = self._world.current()
        self._servos.drive(arrays, self._rows, targets)
        mj.mj_step(model, data)
        # Forces and poses are still those at the beginning of the step.
        self._wrenches = np.zeros((len(self.cells), 6))
        sum_wrenches(
            arrays.readings, self._addresses, arrays.origins, self._fingertips, self._wrenches
        )
        self._moved = True
        if self._window is not None:
            self._window.show(model, data)

    def _placed(self) -> Any:
        """Return the state, with all poses as of now."""
        data = self._world.data
        # A step leaves the poses of its beginning, so they are computed again when they are first
        # read.
        if self._moved:
            mj.mj_kinematics(self._world.model, data)
            self._moved = False
        return data

    def read(self) -> tuple[Floats, Floats]:
        data, (positions, velocities) = self._world.data, self._rows
        return data.qpos[positions], data.qvel[velocities]

    def all_positions(self) -> Floats:
        """Return positions of actuated, then coupled joints, rad or m, shape (n + m,)."""
        positions: Floats = self._world.data.qpos[self._positions]
        return positions

    def wrenches(self) -> Floats:
        return self._wrenches

    def efforts(self) -> Floats:
        torques: Floats = self._world.data.qfrc_actuator[self._rows[1]]
        return torques

    def close(self) -> None:
        if self._window is not None:
            self._window.close()

    @property
    def placements(self) -> Floats:
        data = self._placed()
        return np.hstack([data.xmat[self._links], data.xpos[self._links]])

    @property
    def solids(self) -> Floats:
        if self.objects:
            data = self._placed()
            numbers = [self._world.body(name).number for name in self.objects]
            self._solids[:, POSITION] = data.xpos[numbers]
            self._solids[:, ROTATION] = data.xmat[numbers]
        return self._solids

    def pose(self, name: str) -> Pose:
        number, data = self._world.body(name).number, self._placed()
        return Pose(data.xpos[number].copy(), data.xmat[number].reshape(3, 3).copy())

    def velocity(self, name: str) -> Floats:
        own = self._world.body(name).twist
        return self._world.data.qvel[own : own + 3].copy() if own >= 0 else np.zeros(3)

    def add(self, item: SceneObject) -> None:
        self.objects[item.name] = item
        self._world.add(item)
        self._gather()

    def remove(self, name: str) -> None:
        del self.objects[name]
        self._world.remove(name)
        self._gather()

    def _gather(self) -> None:
        """Allocate a new array for the solids after a change of the objects."""
        solids = [solid_row(item.shape, item.pose) for item in self.objects.values()]
        self._solids = np.array(solids).reshape(len(solids), WIDTH)
        self._moved = True

    def attach(self, name: str) -> None:
        """Attach an object, which keeps its orientation; see ``Engine``."""
        pose, grip = self.pose(name), self._world.body(name).grip
        goal = self._world.model.eq_data[grip]
        # The data of a weld: anchor, relative position, and relative rotation as a quaternion.
        goal[:3], goal[3:6], goal[6:10] = 0.0, pose.position, wxyz(pose)
        self._world.data.eq_active[grip] = True

    def lead(self, name: str, position: Floats, velocity: Floats) -> None:
        self._world.model.eq_data[self._world.body(name).grip, 3:6] = position

    def release(self, name: str) -> None:
        data, body = self._world.data, self._world.body(name)
        if data.eq_active[body.grip]:
            data.eq_active[body.grip] = False
            self.launch(name, np.zeros(3))

    def launch(self, name: str, velocity: Floats) -> None:
        own = self._world.body(name).twist
        self._world.data.qvel[own : own + 6] = [*velocity.tolist(), 0.0, 0.0, 0.0]

    def put_back(self, name: str, pose: Pose) -> None:
        data, body = self._world.data, self._world.body(name)
        place, twist = slice(body.pose, body.pose + 7), slice(body.twist, body.twist + 6)
        before, velocity = data.qpos[place].copy(), data.qvel[twist].copy()
        data.qpos[place], data.qvel[twist] = [*pose.position, *wxyz(pose)], 0.0
        self._moved = True
        # MuJoCo measures distances between shapes in place, so the object is moved there first.
        if self._distance(body.number) < ROOM:
            data.qpos[place], data.qvel[twist] = before, velocity
            self._moved = True

    def _distance(self, body: int) -> float:
        """Return the distance of a body from the robot, m, at most ``ROOM``."""
        model, data, fromto = self._world.model, self._placed(), np.zeros(6)
        geoms = np.arange(model.ngeom)
        own, robot = geoms[model.geom_bodyid == body], geoms[self._of_robot(model.geom_bodyid)]
        return min(
            (mj.mj_geomDistance(model, data, a, b, ROOM, fromto) for a in own for b in robot),
            default=ROOM,
        )

    def _of_robot(self, bodies: NDArray[np.int32]) -> NDArray[np.bool_]:
        inside: NDArray[np.bool_] = (bodies >= self._links.start) & (bodies < self._links.stop)
        return inside

    def touched(self, name: str) -> bool:
        return bool(self._of_robot(self._pressing(name)).any())

    def touching(self, name: str) -> frozenset[Cell]:
        pressing = set(self._pressing(name).tolist())
        cells = zip(self.cells, self._fingertips.tolist(), strict=True)
        return frozenset(cell for cell, tip in cells if tip in pressing)

    def neighbours(self, name: str) -> frozenset[str]:
        """Return the names of the other objects that touch an object.

        The contact of a light object under a press comes and goes from step to step. The last step
        alone does not show it.
        """
        pressing, body = set(self._pressing(name).tolist()), self._world.body
        return frozenset(
            other
            for other in self.objects
            if other != name
            and (body(other).number in pressing or self._apart(name, other) <= _TOUCHING)
        )

    def link_contacts(self) -> Iterator[LinkContact]:
        """Yield the contacts with a force of all links of the robot, as of the last step."""
        model, data, force = self._world.model, self._world.data, np.zeros(6)
        names = {row + 1: link for link, row in self.rows.items()}
        objects = {self._world.body(name).number: name for name in self.objects}
        for number in range(data.ncon):
            contact = data.contact[number]
            one, two = model.geom_bodyid[contact.geom].tolist()
            mj.mj_contactForce(model, data, number, force)
            if force[0] <= 0.0 or (one not in names and two not in names):
                continue
            # The rows of the frame are its axes; its normal points from the first to the second.
            on_second = contact.frame.reshape(3, 3).T @ force[:3]
            if one not in names:
                one, two, on_second = two, one, -on_second
            other = names.get(two) or objects.get(two, "")
            yield LinkContact(names[one], other, two in names, on_second)

    def push(self, link: str, force: Floats) -> None:
        """Push a link of the robot with a force, world frame, N, until the next push or episode."""
        self._world.data.xfrc_applied[self.rows[link] + 1, :3] = force

    def _apart(self, name: str, other: str) -> float:
        """Return the distance of two objects, m, at most 1 mm."""
        model, data, fromto = self._world.model, self._placed(), np.zeros(6)
        first, second = (
            np.flatnonzero(model.geom_bodyid == self._world.body(each).number)
            for each in (name, other)
        )
        most = 10.0 * _TOUCHING
        return min(
            (mj.mj_geomDistance(model, data, a, b, most, fromto) for a in first for b in second),
            default=most,
        )

    def _pressing(self, name: str) -> NDArray[np.int32]:
        """Return bodies in contact with an object, and the object's own, as of the last step."""
        model, data, body = self._world.model, self._world.data, self._world.body(name).number
        bodies: NDArray[np.int32] = model.geom_bodyid[data.contact.geom].reshape(-1, 2)
        # In elliptic cones, the first row of a contact is its normal force.
        rows = data.contact.efc_address
        forces = np.append(data.efc_force, 0.0)[rows]  # contacts without a row have no force
        pressing: NDArray[np.int32] = bodies[(bodies == body).any(axis=1) & (forces > 0.0)].ravel()
        return pressing
