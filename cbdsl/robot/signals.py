"""Signals: the value and Jacobian of every resource, from what was observed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import LoadCell, RobotDocument
from cbdsl.robot.camera import heading_jacobian
from cbdsl.robot.kinematics import Kinematics
from cbdsl.robot.observation import Observation
from cbdsl.robot.resources import CYCLOPEAN
from cbdsl.robot.uniform import UniformSampler
from cbdsl.robot.vision import Vision
from cbdsl.types.resource import (
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    Heading,
    NetLoad,
    Posture,
    Resource,
    StereoPosition,
    Tip,
    UniformSample,
)

Floats = NDArray[np.float64]

_PARTS = {"force": slice(0, 3), "torque": slice(3, 6), "wrench": slice(0, 6)}


class SensorError(Exception):
    """A sensor gave NaN or infinity; the message names it."""


@dataclass(frozen=True)
class Reading:
    """A resource's value in one tick.

    Attributes:
        value: SI, shape (m,); an orientation is a rotation matrix, shape (3, 3), and a pose a
            homogeneous transform from tip to world, shape (4, 4).
        jacobian: change of the value per joint, shape (m, n) over all actuated joints; an
            orientation's is its angular velocity in world axes, shape (3, n), and a pose's is
            linear above angular velocity, shape (6, n).
        stamp: counts the measurements, so that a value which was only repeated is recognised.
        radius: apparent radius of a seen thing, m.
    """

    value: Floats
    jacobian: Floats
    stamp: int
    radius: float = 0.0


class Signals:
    """Reads resources, tick by tick.

    Undefined signals read as ``None``: a channel without a region, a hand without contact.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, resources: Iterable[Resource]
    ) -> None:
        self._robot = robot
        self._readers: dict[type, Callable[[Any], Reading | None]] = {
            EffectorConfiguration: self._configuration,
            Posture: self._posture,
            Tip: self._tip,
            FingerLoad: self._finger_load,
            NetLoad: self._net_load,
            FingerForces: self._finger_forces,
            Heading: self._heading,
            StereoPosition: self._stereo_position,
        }
        self.kinematics = kinematics
        self.joints = kinematics.joints
        self._unit = np.eye(len(self.joints))
        self._flexions = {hand: self._flexion(hand) for hand in robot.load_cells}
        #: By link, the normal of its load cell in its own frame, of unit length.
        self._normals = {
            cell.link: np.array(cell.normal) / math.hypot(*cell.normal)
            for fingers in robot.load_cells.values()
            for cell in fingers.values()
        }
        channels = [
            resource.source.channel
            for resource in resources
            if isinstance(resource.source, (Heading, StereoPosition))
        ]
        self.vision = Vision(robot, kinematics, channels)
        self.reset()

    def reset(self) -> None:
        """Forget the episode before."""
        self.vision.reset()
        self._ticks = 0
        self._tare: dict[tuple[str, str], Floats] = {}
        self._loads: Mapping[tuple[str, str], Floats] = {}
        self._known: dict[str, Reading | None] = {}

    def update(self, observation: Observation) -> None:
        """Take in one tick's observation.

        Raises:
            SensorError: a joint or load cell is not finite.
        """
        _require_finite(observation)
        self._ticks += 1
        self._known.clear()
        self.time = observation.time
        self.positions = observation.positions
        self.kinematics.update(observation.positions)
        # Load cells carry the weight of what is mounted on them: what they read at first is zero.
        if not self._tare:
            self._tare = dict(observation.loads)
        self._loads = {key: load - self._tare[key] for key, load in observation.loads.items()}
        self.vision.update(observation.time, observation.images)
        if any(self.in_contact(hand) for hand in self._robot.load_cells):
            self.vision.touched()

    def in_contact(self, hand: str) -> bool:
        """Whether any fingertip of a hand feels more than the contact threshold."""
        return any(self._force(hand, finger) is not None for finger in self._fingers(hand))

    def read(self, resource: Resource) -> Reading | None:
        """The resource's value now, or ``None`` while it is undefined."""
        if resource.name not in self._known:
            source = resource.source
            self._known[resource.name] = self._readers[type(source)](source)
        return self._known[resource.name]

    def defined(self, resource: Resource) -> bool:
        """Whether ``read`` would give a value."""
        source = resource.source
        if isinstance(source, Tip):
            return True
        if isinstance(source, FingerForces):
            return self._forces(source.hand) is not None
        return self.read(resource) is not None

    def sampler(self, resource: Resource, rng: np.random.Generator) -> UniformSampler:
        """Draws from an internal model."""
        assert isinstance(resource.source, UniformSample)
        own = self.joints.of(resource.source.effector)
        return UniformSampler(self.kinematics.lower[own], self.kinematics.upper[own], rng)

    def normal_forces(self, hand: str) -> Reading:
        """Each finger's force along its normal, N, shape (fingers,), by the joint that flexes it.

        Defined without contact too, as a measured zero, so that a hand can close on something.
        The Jacobian is the cast force -> displacement (Eq 3.37-3.39) with the robot's stiffness.
        """
        value = [
            float(self._normal(cell).dot(self._loads[hand, finger][:3]))
            for finger, cell in self._fingers(hand).items()
        ]
        return Reading(np.array(value), self._flexions[hand], self._ticks)

    def flexion_angles(self, hand: str) -> Floats:
        """Angles of the joints that flex the fingers, rad, shape (fingers,)."""
        joints = [cell.joint for cell in self._fingers(hand).values()]
        return self.positions[self.joints.pick(joints)]

    def shares(self, hand: str) -> Floats:
        """Each finger's share of a force reference, shape (fingers,)."""
        return np.array([cell.share for cell in self._fingers(hand).values()])

    def _selection(self, joints: NDArray[np.intp]) -> Floats:
        """The rows that read ``joints`` from all, shape (len(joints), n)."""
        return self._unit.take(joints, axis=0)

    def _flexion(self, hand: str) -> Floats:
        """Forces along the fingers' normals per joint, N/rad, shape (fingers, n)."""
        joints = [cell.joint for cell in self._fingers(hand).values()]
        return self._selection(self.joints.pick(joints)) * self._robot.control.stiffness

    def _fingers(self, hand: str) -> Mapping[str, LoadCell]:
        return self._robot.load_cells[hand]

    def _force(self, hand: str, finger: str) -> Floats | None:
        force = self._loads[hand, finger][:3]
        return force if math.hypot(*force.tolist()) > self._robot.contact.threshold else None

    def _forces(self, hand: str) -> list[Floats] | None:
        """Each finger's force, N, or ``None`` unless all of them touch something."""
        forces = [self._force(hand, finger) for finger in self._fingers(hand)]
        touching = [force for force in forces if force is not None]
        return touching if len(touching) == len(forces) else None

    def _normal(self, cell: LoadCell) -> Floats:
        normal: Floats = self.kinematics.frame(cell.link).rotation.dot(self._normals[cell.link])
        return normal

    def _configuration(self, source: EffectorConfiguration) -> Reading:
        own = self.joints.of(source.effector)
        return Reading(self.positions[own], self._selection(own), self._ticks)

    def _posture(self, source: Posture) -> Reading:
        angles = self._robot.effectors[source.effector].postures[source.posture]
        return Reading(np.array(angles), np.zeros((len(angles), len(self.joints))), 0)

    def _tip(self, source: Tip) -> Reading:
        return self.tip(source, 0.0)

    def tip(self, source: Tip, standoff: float) -> Reading:
        """A tip's reading, with its control point ``standoff`` metres along the tip's +z axis."""
        tip = self._robot.effectors[source.effector].tip
        assert tip is not None
        frame, jacobian = self.kinematics.frame(tip.link), self.kinematics.jacobian(tip.link)
        if source.part == "orientation":
            return Reading(frame.rotation, jacobian[3:], self._ticks)
        x, y, z = tip.offset
        lever = frame.rotation.dot((x, y, z + standoff))
        # The control point moves by v + omega x lever.
        linear = jacobian[:3] - _cross_matrix(lever).dot(jacobian[3:])
        position = frame.position + lever
        if source.part == "pose":
            pose = transform(frame.rotation, position)
            return Reading(pose, np.vstack((linear, jacobian[3:])), self._ticks)
        return Reading(position, linear, self._ticks)

    def _finger_load(self, source: FingerLoad) -> Reading | None:
        if self._force(source.hand, source.finger) is None:
            return None
        value = self._loads[source.hand, source.finger][_PARTS[source.part]]
        return Reading(value, np.zeros((len(value), len(self.joints))), self._ticks)

    def _net_load(self, source: NetLoad) -> Reading | None:
        if not self.in_contact(source.hand):
            return None
        loads = [self._loads[source.hand, finger] for finger in self._fingers(source.hand)]
        value = np.sum(loads, axis=0)[_PARTS[source.part]]
        return Reading(value, np.zeros((len(value), len(self.joints))), self._ticks)

    def _finger_forces(self, source: FingerForces) -> Reading | None:
        forces = self._forces(source.hand)
        if forces is None:
            return None
        normals = [self._normal(cell) for cell in self._fingers(source.hand).values()]
        jacobian = np.vstack(
            [np.outer(n, row) for n, row in zip(normals, self._flexions[source.hand], strict=True)]
        )
        return Reading(np.concatenate(forces), jacobian, self._ticks)

    def _heading(self, source: Heading) -> Reading | None:
        names = list(self._robot.cameras) if source.camera == CYCLOPEAN else [source.camera]
        seen = [name for name in names if (name, source.channel) in self.vision.headings]
        if not seen:
            return None
        angles = [self.vision.headings[name, source.channel] for name in seen]
        jacobians = [self._heading_jacobian(name, a) for name, a in zip(seen, angles, strict=True)]
        stamp = max(self.vision.stamps[name, source.channel] for name in seen)
        return Reading(np.mean(angles, axis=0), np.mean(jacobians, axis=0), stamp)

    def _heading_jacobian(self, camera: str, angles: Floats) -> Floats:
        link = self._robot.cameras[camera].link
        turning = self.kinematics.frame(link).rotation.T @ self.kinematics.jacobian(link)[3:]
        jacobian: Floats = heading_jacobian(angles) @ turning
        return jacobian

    def _stereo_position(self, source: StereoPosition) -> Reading | None:
        memory = self.vision.memories[source.channel]
        if memory.position is None:
            return None
        still = np.zeros((3, len(self.joints)))
        return Reading(memory.position, still, self.vision.images, memory.radius)


def transform(rotation: Floats, position: Floats) -> Floats:
    """The homogeneous transform (4, 4) of a rotation (3, 3) and a position (3,), m."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose


def _cross_matrix(v: Floats) -> Floats:
    """The matrix that takes the cross product with ``v`` from the left."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _require_finite(observation: Observation) -> None:
    # A sum of squares is NaN or infinite as soon as one of its terms is.
    moving = observation.positions.dot(observation.positions)
    moving += observation.velocities.dot(observation.velocities)
    if not math.isfinite(moving):
        raise SensorError("a joint position or velocity is not finite")
    for (hand, finger), load in observation.loads.items():
        if not math.isfinite(load.dot(load)):
            raise SensorError(f"the load cell {hand}.{finger} is not finite")
