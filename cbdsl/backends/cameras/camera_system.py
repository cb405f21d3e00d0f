"""The camera system: a robot's cameras, whatever makes their images."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.pose import Pose
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance
from cbdsl.sensing.channels import Region
from cbdsl.sensing.observation import Image

Floats = NDArray[np.float64]


class Exposure(NamedTuple):
    """Images, or the regions that ideal cameras see instead, by camera."""

    images: Mapping[str, Image] = {}
    regions: Mapping[str, Mapping[str, Region]] = {}


class Chance(NamedTuple):
    """Generators of an episode: one for the cameras' errors, one for the sensors' noise."""

    errors: np.random.Generator
    noise: np.random.Generator


class CameraSystem(ABC):
    """All cameras of a robot.

    Each is where the robot's model has it but for an error, drawn once in an episode: a distance
    in a random direction and an angle about a random axis.

    Args:
        robot: names the cameras and their links.
        renderer: what makes the images, for people.
    """

    def __init__(self, robot: RobotDocument, renderer: str) -> None:
        self._robot, self._cameras, self.renderer = robot, robot.cameras, renderer

    def begin(
        self,
        engine: Engine,
        disturbance: Disturbance,
        channels: Collection[str] | None,
        chance: Chance,
    ) -> None:
        """Begin an episode.

        Args:
            engine: where links and objects are.
            disturbance: sizes of the cameras' errors and of the images' noise.
            channels: whose regions are looked for, all of them when ``None``.
            chance: draws errors and noise.
        """
        self._engine = engine
        disturbed = disturbance.camera_position or disturbance.camera_rotation
        names = self._cameras if disturbed else ()
        self._errors = {name: _error(disturbance, chance.errors) for name in names}

    @abstractmethod
    def take(self) -> Exposure:
        """Expose all cameras now."""

    def close(self) -> None:  # noqa: B027 (ideal ones hold nothing)
        """Free what makes the images."""


def _error(disturbance: Disturbance, rng: np.random.Generator) -> Pose:
    turned = Pose.turned(_direction(rng), disturbance.camera_rotation)
    return Pose(disturbance.camera_position * _direction(rng), turned.rotation)


def _direction(rng: np.random.Generator) -> Floats:
    """A unit vector, shape (3,), drawn evenly from all directions."""
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)
