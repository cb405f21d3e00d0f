"""Signals: the value and Jacobian of every resource, from what was observed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.sensing.density import DensitySampler, Sampler
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.reading import Reading
from cbdsl.sensing.sight import Sight
from cbdsl.sensing.tips import Tips
from cbdsl.sensing.touch import Touch
from cbdsl.sensing.uniform import UniformSampler
from cbdsl.sensing.vision import Vision
from cbdsl.types.resource import (
    Centroid,
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    GaussianSample,
    Heading,
    Headings,
    KernelSample,
    NetForces,
    NetLoad,
    Posture,
    Resource,
    Separation,
    StereoPosition,
    Tip,
    UniformSample,
)

Floats = NDArray[np.float64]


class SensorError(Exception):
    """A sensor gave NaN or infinity; the message names it."""


class Signals:
    """Reads resources, tick by tick.

    Undefined signals read as ``None``: a channel without a region, a hand without contact.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, resources: Iterable[Resource]
    ) -> None:
        self._robot = robot
        self.kinematics = kinematics
        self.joints = kinematics.joints
        self._unit = np.eye(len(self.joints))
        self._selections: dict[str, Floats] = {}
        self._postures: dict[Posture, Reading] = {}
        channels = [
            resource.source.channel
            for resource in resources
            if isinstance(resource.source, (Heading, Headings, StereoPosition))
        ]
        self.vision = Vision(robot, kinematics, channels)
        self.tips = Tips(robot, kinematics)
        self.touch = Touch(robot, kinematics, self.tips)
        self.sight = Sight(robot, kinematics, self.vision, self.tips, self.touch)
        self._readers: dict[type, Callable[[Any], Reading | None]] = {
            EffectorConfiguration: self._configuration,
            Posture: self._posture,
            Tip: self.tips.read,
            Centroid: self.tips.centroid,
            Separation: self.tips.separation,
            FingerLoad: self.touch.finger_load,
            NetLoad: self.touch.net_load,
            NetForces: self.touch.net_forces,
            FingerForces: self.touch.finger_forces,
            Heading: self.sight.heading,
            Headings: self.sight.headings,
            StereoPosition: self.sight.position,
        }
        self.reset()

    def reset(self) -> None:
        """Forget the episode before."""
        self.vision.reset()
        self.touch.reset()
        self.sight.reset()
        self.tips.stamp = 0
        self._known: dict[str, Reading | None] = {}

    def update(self, observation: Observation) -> None:
        """Take in one tick's observation.

        Raises:
            SensorError: a joint or load cell is not finite.
        """
        wrenches = self.touch.gathered(observation.loads)
        self._require_finite(observation, wrenches)
        self.tips.stamp += 1
        self._known.clear()
        self.time = observation.time
        self.positions = observation.positions
        self.kinematics.update(observation.positions)
        if self._robot.load_cells:
            self.touch.update(wrenches)
            self.sight.update()
        if self._robot.cameras:
            self.vision.update(observation)
            if self.touch.touching_anything():
                self.vision.touched()
            else:
                self.vision.untouched()

    def read(self, resource: Resource) -> Reading | None:
        """The resource's value now, or ``None`` while it is undefined."""
        name = resource.name
        if name in self._known:
            return self._known[name]
        source = resource.source
        found = self._known[name] = self._readers[type(source)](source)
        return found

    def defined(self, resource: Resource) -> bool:
        """Whether ``read`` would give a value."""
        source = resource.source
        # Of forces, this takes less time than to read them.
        if isinstance(source, FingerForces):
            return self.touch.all_touching(source.hand)
        return self.read(resource) is not None

    def sampler(self, resource: Resource, rng: np.random.Generator) -> Sampler:
        """Draws from an internal model."""
        source = resource.source
        assert isinstance(source, (UniformSample, GaussianSample, KernelSample))
        own = self.joints.of(source.effector)
        limits = self.kinematics.lower[own], self.kinematics.upper[own]
        if isinstance(source, UniformSample):
            return UniformSampler(*limits, rng)
        return DensitySampler(source, *limits, rng)

    def _configuration(self, source: EffectorConfiguration) -> Reading:
        own = self.joints.of(source.effector)
        rows = self._selections.get(source.effector)
        if rows is None:
            rows = self._selections[source.effector] = self._unit.take(own, axis=0)
        return Reading(self.positions.take(own), rows, self.tips.stamp)

    def _posture(self, source: Posture) -> Reading:
        known = self._postures.get(source)
        if known is None:
            angles = [
                angle
                for member in self._robot.members(source.effector)
                for angle in self._robot.effectors[member].postures[source.posture]
            ]
            known = Reading(np.array(angles), np.zeros((len(angles), len(self.joints))), 0)
            self._postures[source] = known
        return known

    def _require_finite(self, observation: Observation, wrenches: Floats) -> None:
        if not _have_squares(observation.positions, observation.velocities, wrenches):
            self._refuse(observation)

    def _refuse(self, observation: Observation) -> None:
        """Say which sensor gave a number that is not finite, or too large to compute with."""
        measured = {"position": observation.positions, "velocity": observation.velocities}
        for what, values in measured.items():
            if not math.isfinite(values.dot(values)):
                joint = self.joints.names[int(np.argmax(np.abs(values)))]
                raise SensorError(f"the {what} of {self._owner(joint)} is not finite")
        for (hand, finger), load in observation.loads.items():
            if not math.isfinite(load.dot(load)):
                raise SensorError(f"the load cell {hand}.{finger} is not finite")
        raise SensorError("the sensors' numbers are too large to compute with")

    def _owner(self, joint: str) -> str:
        """A joint, and the resource that it belongs to."""
        effectors = self._robot.effectors.items()
        return next(f"joint {joint} of {name}" for name, each in effectors if joint in each.joints)


@compiled_once
def _have_squares(positions: Floats, velocities: Floats, wrenches: Floats) -> bool:
    """Whether all numbers are finite, and small enough to compute with."""
    squares = _square(positions) + _square(velocities)
    for wrench in wrenches:
        squares += _square(wrench)
    return math.isfinite(squares)


@compiled
def _square(numbers: Floats) -> float:
    total = 0.0
    for number in numbers:
        total += number * number
    return total
