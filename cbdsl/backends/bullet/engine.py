"""PyBullet as an engine: the robot, the objects of a stage, and their contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pybullet as p

from cbdsl.backends.bullet.articulation import BulletRobot
from cbdsl.backends.bullet.composed import create_composed
from cbdsl.backends.staging.engine import ROOM, Engine
from cbdsl.backends.staging.load_cells import ContactPoint, sum_wrenches
from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.backends.staging.solids import POSITION, ROTATION, WIDTH, solid_row
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.kinematics.quaternion import rotations
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfModel
from cbdsl.sensing.observation import Cell

Triple = tuple[float, float, float]

_KINDS = {"ball": p.GEOM_SPHERE, "box": p.GEOM_BOX, "cylinder": p.GEOM_CYLINDER}
# Largest force of the constraint with which the experimenter holds an object, N.
_HOLDING_FORCE = 1000.0


class BulletEngine(Engine):
    """A robot in PyBullet; see ``Engine``.

    Every episode starts from an empty world, so that nothing of the last one, such as a cached
    contact, affects it.

    Args:
        robot: Robot document.
        model: URDF model of the robot.
        timestep: Period of a physics step, s.
        gui: True to open a window.

    Attributes:
        client: Number of the simulator's connection.
        robot: Simulated robot.
        bodies: The simulator's number of each object.

    Raises:
        BackendError: The simulator cannot read the model, or the robot file names links that the
            model does not have.
    """

    def __init__(
        self, robot: RobotDocument, model: UrdfModel, timestep: float, *, gui: bool
    ) -> None:
        self._document, self._model, self._timestep = robot, model, timestep
        self.client: int = p.connect(p.GUI if gui else p.DIRECT)
        try:
            self._empty()
        except Exception:
            self.close()
            raise
        # The base has the number -1 in the simulator, and the first row here.
        self.rows = {link: number + 1 for link, number in self.robot.links.items()}
        links = {
            (hand, finger): self.robot.links[cell.link]
            for hand, fingers in robot.load_cells.items()
            for finger, cell in fingers.items()
        }
        self.cells = tuple(links)
        self._fingertips = list(links.values())
        self._cell_of_link = {link: cell for cell, link in links.items()}

    def _empty(self) -> None:
        """Remove everything but the robot from the world."""
        p.resetSimulation(physicsClientId=self.client)
        p.setGravity(0, 0, -GRAVITY, physicsClientId=self.client)
        p.setPhysicsEngineParameter(
            fixedTimeStep=self._timestep,
            numSolverIterations=self._document.simulation.solver_iterations,
            numSubSteps=0,
            # Contacts are solved in the same order in each run, so that seeds repeat bit by bit.
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self.robot = BulletRobot(self.client, self._document, self._model, self._timestep)
        self.objects: dict[str, SceneObject] = {}
        self.bodies: dict[str, int] = {}
        self._held: dict[str, tuple[int, Sequence[float]]] = {}
        self._solids: Floats = np.empty((0, WIDTH))

    def begin(self, positions: Floats) -> None:
        self._empty()
        self.robot.place(positions)

    def step(self, targets: Floats) -> None:
        self.robot.drive(targets)
        p.stepSimulation(physicsClientId=self.client)

    def read(self) -> tuple[Floats, Floats]:
        return self.robot.read()

    def efforts(self) -> Floats:
        return self.robot.efforts()

    def close(self) -> None:
        p.disconnect(physicsClientId=self.client)

    def add(self, item: SceneObject) -> None:
        body, surface = self._create(item), item.surface
        self.objects[item.name], self.bodies[item.name] = item, body
        p.changeDynamics(
            body,
            -1,
            lateralFriction=surface.friction,
            rollingFriction=surface.rolling_friction,
            spinningFriction=surface.spinning,
            linearDamping=0,
            angularDamping=0,
            physicsClientId=self.client,
        )
        self._gather()

    def _create(self, item: SceneObject) -> int:
        shape, client = item.shape, self.client
        if shape.pattern is not None or shape.spots or shape.walls or shape.mesh:
            return create_composed(client, item)
        kind, color = _KINDS[shape.kind], [*item.surface.color, 1]
        # The simulator has two words for a cylinder's extent.
        collision, visual = _size(shape, "height"), _size(shape, "length")
        return int(
            p.createMultiBody(
                item.mass,
                p.createCollisionShape(kind, physicsClientId=client, **collision),
                p.createVisualShape(kind, rgbaColor=color, physicsClientId=client, **visual),
                item.pose.position.tolist(),
                item.pose.quaternion(),
                physicsClientId=client,
            )
        )

    def _gather(self) -> None:
        """Allocate a new array for the solids after a change of the objects."""
        solids = [solid_row(item.shape, item.pose) for item in self.objects.values()]
        self._solids = np.array(solids).reshape(len(solids), WIDTH)

    def remove(self, name: str) -> None:
        del self.objects[name]
        self.release(name)
        p.removeBody(self.bodies.pop(name), physicsClientId=self.client)
        self._gather()

    @property
    def solids(self) -> Floats:
        for solid, body in zip(self._solids, self.bodies.values(), strict=True):
            position, quaternion = p.getBasePositionAndOrientation(
                body, physicsClientId=self.client
            )
            solid[POSITION] = position
            solid[ROTATION] = rotations(np.array(quaternion)).ravel()
        return self._solids

    @property
    def placements(self) -> Floats:
        return self.robot.placements()

    def pose(self, name: str) -> Pose:
        return Pose.of(
            *p.getBasePositionAndOrientation(self.bodies[name], physicsClientId=self.client)
        )

    def velocity(self, name: str) -> Floats:
        return np.array(p.getBaseVelocity(self.bodies[name], physicsClientId=self.client)[0])

    def attach(self, name: str) -> None:
        """Attach an object, which keeps its orientation; see ``Engine``."""
        pose = self.pose(name)
        quaternion = pose.quaternion()
        constraint = p.createConstraint(
            self.bodies[name],
            -1,
            -1,
            -1,
            p.JOINT_FIXED,
            [0, 0, 0],
            [0, 0, 0],
            pose.position.tolist(),
            childFrameOrientation=quaternion,
            physicsClientId=self.client,
        )
        self._held[name] = constraint, quaternion
        self.lead(name, pose.position, np.zeros(3))

    def lead(self, name: str, position: Floats, velocity: Floats) -> None:
        constraint, quaternion = self._held[name]
        p.changeConstraint(
            constraint,
            jointChildPivot=position.tolist(),
            jointChildFrameOrientation=quaternion,
            maxForce=_HOLDING_FORCE,
            physicsClientId=self.client,
        )

    def release(self, name: str) -> None:
        if name in self._held:
            p.removeConstraint(self._held.pop(name)[0], physicsClientId=self.client)

    def launch(self, name: str, velocity: Floats) -> None:
        p.resetBaseVelocity(
            self.bodies[name], velocity.tolist(), [0, 0, 0], physicsClientId=self.client
        )

    def put_back(self, name: str, pose: Pose) -> None:
        body, before = self.bodies[name], self.pose(name)
        velocity = p.getBaseVelocity(body, physicsClientId=self.client)
        self._put(body, pose, ([0, 0, 0], [0, 0, 0]))
        # The simulator measures distances between bodies in place, so the object is moved there
        # first.
        if p.getClosestPoints(self.robot.id, body, ROOM, physicsClientId=self.client):
            self._put(body, before, velocity)

    def _put(self, body: int, pose: Pose, velocity: tuple[list[float], list[float]]) -> None:
        where = pose.position.tolist(), pose.quaternion()
        p.resetBasePositionAndOrientation(body, *where, physicsClientId=self.client)
        p.resetBaseVelocity(body, *velocity, physicsClientId=self.client)

    def touched(self, name: str) -> bool:
        contacts = p.getContactPoints(
            bodyA=self.robot.id, bodyB=self.bodies[name], physicsClientId=self.client
        )
        return any(contact[9] for contact in contacts)

    def touching(self, name: str) -> frozenset[Cell]:
        return frozenset(touch.cell for touch in self.touches(name))

    def neighbours(self, name: str) -> frozenset[str]:
        """Return the names of the other objects that press on an object, as of the last step."""
        contacts = p.getContactPoints(bodyA=self.bodies[name], physicsClientId=self.client)
        pressing = {contact[2] for contact in contacts if contact[9]}
        return frozenset(other for other, body in self.bodies.items() if body in pressing)

    def touches(self, name: str | None = None) -> list[ContactPoint]:
        """Return the contact points of the fingertips, with everything or with one object."""
        touches = list(self._touches())
        if name is None:
            return touches
        return [touch for touch in touches if touch.other == self.bodies[name]]

    def _touches(self) -> Iterator[ContactPoint]:
        own, cells = self.robot.id, self._cell_of_link
        for contact in p.getContactPoints(bodyA=own, physicsClientId=self.client):
            body_a, body_b, link_a, link_b = contact[1:5]
            # The simulator also lists points of bodies that are only near each other, without a
            # force.
            if not contact[9]:
                continue
            # If two fingertips touch each other, both conditions hold, and both load cells measure
            # the contact.
            if body_a == own and link_a in cells:
                yield ContactPoint(cells[link_a], body_b, contact[5], *_force(contact, -1.0))
            if body_b == own and link_b in cells:
                yield ContactPoint(cells[link_b], body_a, contact[6], *_force(contact, 1.0))

    def wrenches(self) -> Floats:
        touches = self.touches()
        if not touches:
            return np.zeros((len(self.cells), 6))
        states = p.getLinkStates(self.robot.id, self._fingertips, physicsClientId=self.client)
        # Torques are about the URDF's link frame, not about the link's centre of mass.
        origins = {cell: state[4] for cell, state in zip(self.cells, states, strict=True)}
        return sum_wrenches(self.cells, touches, origins)


def _force(contact: Any, sign: float) -> tuple[Triple, float]:
    """Return the force that a fingertip exerts, N, and its share along the contact normal, N.

    ``sign`` is 1 if the fingertip is the contact's second body: forces act on the first.
    """
    (nx, ny, nz), pressure = contact[7], contact[9]
    f, (fx, fy, fz) = contact[10], contact[11]
    g, (gx, gy, gz) = contact[12], contact[13]
    force = (
        sign * (pressure * nx + f * fx + g * gx),
        sign * (pressure * ny + f * fy + g * gy),
        sign * (pressure * nz + f * fz + g * gz),
    )
    return force, pressure


def _size(shape: SolidShape, height: str) -> dict[str, Any]:
    """Return a shape's size by the simulator's names; ``height`` names a cylinder's height."""
    if shape.kind == "box":
        return {"halfExtents": shape.halves}
    if shape.kind == "ball":
        return {"radius": shape.halves[0]}
    return {"radius": shape.halves[0], height: 2 * shape.half_height}
