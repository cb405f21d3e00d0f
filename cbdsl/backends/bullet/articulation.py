"""The robot in PyBullet: its joints, links, servos and surfaces."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from itertools import combinations
from pathlib import PurePosixPath

import numpy as np
import pybullet as p

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.links import link_surfaces, matching_links
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.link_mass import link_masses, moved_inertia
from cbdsl.kinematics.quaternion import rotations
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel

# Torque of servos without a limit, N m; the simulator has no infinite torque.
_STRONGEST = 1e6

# Largest number of joints of one body in PyBullet, fixed joints included.
_MOST_JOINTS = 127

# Without the first flag the simulator computes inertias from collision shapes. The last one ignores
# contacts of a link with the links that carry it, as the MuJoCo backend does.
_FLAGS = (
    p.URDF_USE_INERTIA_FROM_FILE
    | p.URDF_USE_SELF_COLLISION
    | p.URDF_USE_SELF_COLLISION_EXCLUDE_ALL_PARENTS
)


class BulletRobot:
    """Robot in PyBullet with its base at the origin of the world.

    The servos keep the URDF's limits. A servo moves a joint at a speed in proportion to its
    position error. Errors above the one for the largest speed are cut off. Torques are bounded by
    the smaller of the robot file's and the URDF's efforts.

    Args:
        client: Number of the simulator's connection.
        robot: Robot document, which names joints and surfaces.
        model: URDF model of the robot.
        timestep: Period of a physics step, s.

    Attributes:
        id: The simulator's number of the robot.
        links: The simulator's number of every link; -1 for the base.

    Raises:
        BackendError: The model cannot be read, or lacks something that the robot file names.
    """

    def __init__(
        self, client: int, robot: RobotDocument, model: UrdfModel, timestep: float
    ) -> None:
        self._client, self._document, self._model = client, robot, model
        self._joints = joints = Joints(robot)
        require_known_endings(model)
        try:
            self.id: int = p.loadURDF(
                str(model.path), useFixedBase=True, flags=_FLAGS, physicsClientId=client
            )
        except p.error as error:
            raise BackendError(
                f"the simulator cannot read the model {model.path}: {error}"
            ) from error
        count = p.getNumJoints(self.id, physicsClientId=client)
        if count > _MOST_JOINTS:
            raise BackendError(
                f"{model.path.name} has {count} joints, fixed ones too, and PyBullet reads "
                f"{_MOST_JOINTS} at most; use the engine mujoco or kinematic"
            )
        rows = [p.getJointInfo(self.id, index, physicsClientId=client) for index in range(count)]
        self.links = {robot.base: -1} | {row[12].decode(): row[0] for row in rows}
        require_collisions(client, self.id, model, self.links)
        numbers = {row[1].decode(): row[0] for row in rows}
        self._indices = [numbers[name] for name in joints.all]
        self._actuated = self._indices[: len(joints)]
        self._follows = [joints.index[each.follows] for each in robot.couplings.values()]
        self._ratios = np.array([each.ratio for each in robot.couplings.values()])
        self._offsets = joints.offsets[len(joints) :]
        self._resting = {
            numbers[name]: position
            for name, position in model.rests.items()
            if name not in joints.index
        }
        simulation = robot.simulation
        limits = [model.joints[name] for name in joints.all]
        self._efforts = [
            min(simulation.efforts.get(joint.name, _STRONGEST), joint.effort, _STRONGEST)
            for joint in limits
        ]
        # In a step of dt, a servo with the gain k turns the error e into the speed k e / dt. So the
        # errors are cut off at v dt / k to keep the speed limit v.
        fastest = timestep * np.array([joint.velocity for joint in limits])
        self._largest_error = fastest / max(simulation.position_gain, 1e-9)
        self._gains = simulation.position_gain, simulation.velocity_gain
        self._weigh()
        self._add_rotors(timestep)
        self._soften(count)
        self._ignore_contacts(simulation.no_contact)

    def _matching(self, patterns: Iterable[str]) -> list[int]:
        return [self.links[name] for name in matching_links(self._document, self._model, patterns)]

    def _weigh(self) -> None:
        """Set the masses of links for which the simulator has others than the model.

        It gives a link without mass 1 kg, and no inertia to a link with impossible moments.
        """
        for link, of in link_masses(self._model).items():
            number = self.links[link]
            if number < 0:
                continue  # the base does not move
            row = p.getDynamicsInfo(self.id, number, physicsClientId=self._client)
            axes = rotations(np.array(row[4]))
            moments = np.diag(axes.T @ of.inertia @ axes)
            if not np.allclose([row[0], *row[2]], [of.mass, *moments], rtol=1e-6, atol=0.0):
                p.changeDynamics(
                    self.id,
                    number,
                    mass=of.mass,
                    localInertiaDiagonal=moments.tolist(),
                    physicsClientId=self._client,
                )

    # The simulator solves motors and contacts in turn, in N iterations a step. In each one, a motor
    # passes on the impulse that brings its joint of inertia I to its largest speed v. So a finger
    # with light links exerts at most N I v / dt. A gripper with coupled joints would bend at its
    # inner joints, and go on closing around an object. The rotor of a drive, which models leave
    # out, makes such a joint as heavy as its effort needs. Other joints have longer, heavier links.
    def _add_rotors(self, timestep: float) -> None:
        """Add rotors to coupled joints that are too light for their efforts."""
        model, couplings = self._model, self._document.couplings
        masses = link_masses(model)
        efforts = dict(zip(self._joints.all, self._efforts, strict=True))
        # A follower bears no more than the joint that leads it, which also bears its links.
        bearing = {name: min(efforts[name], efforts[of.follows]) for name, of in couplings.items()}
        bearing |= {of.follows: efforts[of.follows] for of in couplings.values()}
        speeds = self._document.simulation.solver_iterations / timestep
        for name, effort in bearing.items():
            joint = model.joints[name]
            # Mass instead of a rotor would be a weight.
            if joint.slides or effort >= _STRONGEST or math.isinf(joint.velocity):
                continue
            lacking = effort / (speeds * joint.velocity) - moved_inertia(model, name, masses)
            if lacking > 0.0:
                number = self.links[joint.child]
                row = p.getDynamicsInfo(self.id, number, physicsClientId=self._client)
                p.changeDynamics(
                    self.id,
                    number,
                    localInertiaDiagonal=[moment + lacking for moment in row[2]],
                    physicsClientId=self._client,
                )

    def _soften(self, count: int) -> None:
        """Set damping to that of the servos alone, and surfaces to those of the robot file."""
        for link in range(-1, count):
            p.changeDynamics(
                self.id,
                link,
                linearDamping=0,
                angularDamping=0,
                jointDamping=0,
                physicsClientId=self._client,
            )
        for name, surface in link_surfaces(self._document, self._model).items():
            given = {"contactStiffness": surface.stiffness, "contactDamping": surface.damping}
            p.changeDynamics(
                self.id,
                self.links[name],
                lateralFriction=surface.friction,
                frictionAnchor=int(surface.friction_anchor),
                physicsClientId=self._client,
                **{key: value for key, value in given.items() if value is not None},
            )

    def _ignore_contacts(self, groups: Iterable[Iterable[str]]) -> None:
        carried = [[self.links[link] for link in pair] for pair in self._model.carried_pairs()]
        for group in [*carried, *map(self._matching, groups)]:
            for first, second in combinations(sorted(set(group)), 2):
                p.setCollisionFilterPair(
                    self.id, self.id, first, second, 0, physicsClientId=self._client
                )

    def place(self, positions: Floats) -> None:
        """Put the actuated joints at ``positions``, rad, shape (n,), at rest; couplings follow.

        Joints that the robot file does not name are held at their rest positions.
        """
        for index, position in self._resting.items():
            p.resetJointState(self.id, index, position, 0.0, physicsClientId=self._client)
            p.setJointMotorControl2(
                self.id,
                index,
                p.POSITION_CONTROL,
                targetPosition=position,
                positionGain=self._gains[0],
                velocityGain=self._gains[1],
                force=_STRONGEST,
                physicsClientId=self._client,
            )
        for index, angle in zip(self._indices, self._joints.expand(positions), strict=True):
            p.resetJointState(self.id, index, float(angle), 0.0, physicsClientId=self._client)

    def drive(self, targets: Floats) -> None:
        """Set the targets of the servos, rad, shape (n,).

        A passive joint's target follows from the measured position of its leading joint, not from
        the reference. So a fingertip that is held back does not bend the joint behind it.
        """
        states = p.getJointStates(self.id, self._indices, physicsClientId=self._client)
        positions = np.array([state[0] for state in states])
        wanted = np.concatenate((targets, self._ratios * positions[self._follows] + self._offsets))
        # The limit of speed is kept by the target, for any reference that a program sends.
        least, most = positions - self._largest_error, positions + self._largest_error
        ones = [1.0] * len(wanted)
        p.setJointMotorControlArray(
            self.id,
            self._indices,
            p.POSITION_CONTROL,
            targetPositions=np.minimum(np.maximum(wanted, least), most).tolist(),
            positionGains=[self._gains[0] * one for one in ones],
            velocityGains=[self._gains[1] * one for one in ones],
            forces=self._efforts,
            physicsClientId=self._client,
        )

    def read(self) -> tuple[Floats, Floats]:
        """Return the actuated joints' positions and velocities, rad and rad/s, shape (n,) each."""
        states = p.getJointStates(self.id, self._actuated, physicsClientId=self._client)
        return np.array([state[0] for state in states]), np.array([state[1] for state in states])

    def efforts(self) -> Floats:
        """Return the torques of the actuated joints' servos in the last step, N m, shape (n,)."""
        states = p.getJointStates(self.id, self._actuated, physicsClientId=self._client)
        return np.array([state[3] for state in states])

    def placements(self) -> Floats:
        """Return rotation by rows, then position, m, of all links, base first, shape (k, 12)."""
        # ``links`` includes the base, which has no state as a link.
        numbers = range(len(self.links) - 1)
        states = p.getLinkStates(
            self.id, list(numbers), computeForwardKinematics=1, physicsClientId=self._client
        )
        placements = np.zeros((len(self.links), 12))
        placements[0, [0, 4, 8]] = 1.0  # the base is the world
        if states:
            quaternions = np.array([state[5] for state in states])
            # The entries 4 and 5 are the URDF's link frame; 0 and 1 would be the centre of mass.
            placements[1:, :9] = rotations(quaternions).reshape(-1, 9)
            placements[1:, 9:] = [state[4] for state in states]
        return placements


_ENDINGS = (".obj", ".stl", ".dae")
_ALLOWED = "convert it to OBJ, binary STL or COLLADA, or use another engine"


def require_known_endings(model: UrdfModel) -> None:
    """Check the formats of the meshes of a model, which the simulator knows by their endings.

    Raises:
        BackendError: The simulator does not know one of the formats.
    """
    for file, link in model.meshes.items():
        if PurePosixPath(file).suffix.lower() not in _ENDINGS:
            raise BackendError(
                f"{model.path.name}: PyBullet does not read mesh '{file}' of link '{link}'; "
                f"{_ALLOWED}"
            )


def require_collisions(
    client: int, robot: int, model: UrdfModel, numbers: Mapping[str, int]
) -> None:
    """Check that the simulator has read the collision meshes of a robot.

    It leaves out a mesh that it cannot read, such as an STL in text, and only prints a warning.

    Args:
        client: Number of the simulator's connection.
        robot: The simulator's number of the robot.
        model: Model of the robot.
        numbers: The simulator's number of each link.

    Raises:
        BackendError: It has left one out.
    """
    for link, body in model.bodies.items():
        files = [shape.file for shape in body.collisions if shape.kind == "mesh"]
        if not files:
            continue
        rows = p.getCollisionShapeData(robot, numbers[link], physicsClientId=client)
        # A file may be read as more than one mesh, never as less than one.
        if sum(row[2] == p.GEOM_MESH for row in rows) < len(files):
            raise BackendError(
                f"{model.path.name}: PyBullet has no contacts for {_names(files)} of link "
                f"'{link}'; {_ALLOWED}"
            )


def _names(files: list[str]) -> str:
    return f"mesh '{files[0]}'" if len(files) == 1 else f"one of the meshes {', '.join(files)}"
