"""The robot's body in the simulator: its joints, links, motors and surfaces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.pose import Pose
from cbdsl.documents.robot import RobotDocument, Simulation
from cbdsl.robot.joints import Joints

Floats = NDArray[np.float64]

_FLAGS = (
    p.URDF_USE_INERTIA_FROM_FILE
    | p.URDF_USE_SELF_COLLISION
    | p.URDF_USE_SELF_COLLISION_EXCLUDE_ALL_PARENTS
)


@dataclass(frozen=True)
class _Motors:
    """What the simulator's position servos are told besides their targets."""

    joints: list[int]
    position_gains: list[float]
    velocity_gains: list[float]
    efforts: list[float]


class Body:
    """A robot, loaded with its base at the origin of the world.

    Attributes:
        id: the simulator's number for it.
        links: the simulator's number of every link.

    Raises:
        BackendError: the model cannot be read, or lacks something that the robot file names.
    """

    def __init__(self, client: int, robot: RobotDocument, joints: Joints, urdf: Path) -> None:
        self._client = client
        self._robot = robot
        self._joints = joints
        self._urdf = urdf
        try:
            self.id: int = p.loadURDF(
                str(urdf), useFixedBase=True, flags=_FLAGS, physicsClientId=client
            )
        except p.error as error:
            raise BackendError(f"the simulator cannot read the model {urdf}: {error}") from error
        count = p.getNumJoints(self.id, physicsClientId=client)
        rows = [p.getJointInfo(self.id, index, physicsClientId=client) for index in range(count)]
        self.links = self._link_numbers(rows)
        self._indices = self._joint_numbers(rows)
        self._followed = [
            self._indices[joints.index[coupling.follows]] for coupling in robot.couplings.values()
        ]
        self._ratios = np.array([coupling.ratio for coupling in robot.couplings.values()])
        self._actuated = self._indices[: len(joints)]
        self._lower = np.array([rows[index][8] for index in self._actuated])
        self._upper = np.array([rows[index][9] for index in self._actuated])
        self._motors = self._servo_settings(rows, robot.simulation)
        self._soften(count, robot.simulation)
        self._ignore_contacts(robot.simulation.no_contact)

    def _link_numbers(self, rows: Sequence[Any]) -> Mapping[str, int]:
        base = p.getBodyInfo(self.id, physicsClientId=self._client)[0].decode()
        if base != self._robot.base:
            raise BackendError(
                f"robot '{self._robot.name}' has the base '{self._robot.base}', "
                f"but the root link of {self._urdf.name} is '{base}'"
            )
        return {base: -1} | {row[12].decode(): row[0] for row in rows}

    def _joint_numbers(self, rows: Sequence[Any]) -> list[int]:
        movable = {row[1].decode(): row[0] for row in rows if row[2] == p.JOINT_REVOLUTE}
        missing = [name for name in self._joints.all if name not in movable]
        if missing:
            raise BackendError(
                f"{self._urdf.name} has no revolute joint {', '.join(map(repr, missing))}, "
                f"which robot '{self._robot.name}' names"
            )
        return [movable[name] for name in self._joints.all]

    def _servo_settings(self, rows: Sequence[Any], simulation: Simulation) -> _Motors:
        efforts = [
            simulation.efforts.get(name, rows[index][10])
            for name, index in zip(self._joints.all, self._indices, strict=True)
        ]
        ones = [1.0] * len(efforts)
        return _Motors(
            self._indices,
            [simulation.position_gain * one for one in ones],
            [simulation.velocity_gain * one for one in ones],
            efforts,
        )

    def link(self, name: str) -> int:
        """The simulator's number of a link.

        Raises:
            BackendError: the model has no such link.
        """
        if name not in self.links:
            raise BackendError(
                f"{self._urdf.name} has no link '{name}', which robot '{self._robot.name}' names"
            )
        return self.links[name]

    def _matching(self, patterns: Iterable[str]) -> Iterator[int]:
        for pattern in patterns:
            if not pattern.endswith("*"):
                yield self.link(pattern)
                continue
            start = pattern.removesuffix("*")
            found = [index for name, index in self.links.items() if name.startswith(start)]
            if not found:
                raise BackendError(
                    f"{self._urdf.name} has no link that matches '{pattern}', "
                    f"as robot '{self._robot.name}' expects"
                )
            yield from found

    def _soften(self, count: int, simulation: Simulation) -> None:
        """No damping but the servos', and the surfaces of the robot file."""
        for link in range(-1, count):
            p.changeDynamics(
                self.id,
                link,
                linearDamping=0,
                angularDamping=0,
                jointDamping=0,
                physicsClientId=self._client,
            )
        for surface in simulation.surfaces:
            given = {"contactStiffness": surface.stiffness, "contactDamping": surface.damping}
            options = {key: value for key, value in given.items() if value is not None}
            for link in self._matching(surface.links):
                p.changeDynamics(
                    self.id,
                    link,
                    lateralFriction=surface.friction,
                    physicsClientId=self._client,
                    **options,
                )

    def _ignore_contacts(self, groups: Iterable[Iterable[str]]) -> None:
        for group in groups:
            for first, second in combinations(sorted(set(self._matching(group))), 2):
                p.setCollisionFilterPair(
                    self.id, self.id, first, second, 0, physicsClientId=self._client
                )

    def nearest_to_zero(self) -> Floats:
        """The actuated joints' positions nearest to zero within their limits, rad, shape (n,)."""
        nearest: Floats = np.clip(0.0, self._lower, self._upper)
        return nearest

    def place(self, positions: Floats) -> None:
        """Put the actuated joints at ``positions``, rad, shape (n,), at rest; couplings follow."""
        for index, angle in zip(self._indices, self._joints.expand(positions), strict=True):
            p.resetJointState(self.id, index, float(angle), 0.0, physicsClientId=self._client)

    def drive(self, targets: Floats) -> None:
        """Give the servos their targets, rad, shape (n,).

        A passive joint's target is its ratio of where the joint it follows is, not of where that
        one should be: a fingertip that is held back must not bend the joint behind it.
        """
        states = p.getJointStates(self.id, self._followed, physicsClientId=self._client)
        passive = self._ratios * [state[0] for state in states or ()]
        p.setJointMotorControlArray(
            self.id,
            self._motors.joints,
            p.POSITION_CONTROL,
            targetPositions=[*targets.tolist(), *passive.tolist()],
            positionGains=self._motors.position_gains,
            velocityGains=self._motors.velocity_gains,
            forces=self._motors.efforts,
            physicsClientId=self._client,
        )

    def read(self) -> tuple[Floats, Floats]:
        """Positions and velocities of the actuated joints, rad and rad/s, shape (n,) each."""
        states = p.getJointStates(self.id, self._actuated, physicsClientId=self._client)
        return np.array([state[0] for state in states]), np.array([state[1] for state in states])

    def poses(self, links: Sequence[int]) -> list[Pose]:
        """Where these links' frames are in the world; not for the base, which is the world."""
        states = p.getLinkStates(
            self.id, links, computeForwardKinematics=1, physicsClientId=self._client
        )
        return [Pose.of(state[4], state[5]) for state in states]
