"""Camera system: a robot's cameras, independent of the source of their images."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from cbdsl.backends.staging.engine import Engine
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats, Image
from cbdsl.sensing.channels import Regions


class Exposure(NamedTuple):
    """Images, or the regions that ideal cameras see instead, by camera."""

    images: Mapping[str, Image] = {}
    regions: Mapping[str, Mapping[str, Regions]] = {}


class Chance(NamedTuple):
    """Generators of an episode: one for the cameras' errors, one for the sensors' noise."""

    errors: np.random.Generator
    noise: np.random.Generator


class CameraSystem(ABC):
    """All cameras of a robot.

    Each camera is displaced from its pose in the robot's model. The error is a distance in a random
    direction and an angle about a random axis. A robot body with a number keeps its errors in all
    episodes; without a number they are drawn once per episode.

    Args:
        robot: Robot document, which names the cameras and their links.
        renderer: Source of the images, for people.
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
            engine: Engine with the poses of links and objects.
            disturbance: Sizes of the cameras' errors and of the images' noise.
            channels: Channels whose regions are looked for; all if ``None``.
            chance: Generators of errors and noise.
        """
        self._engine = engine
        self._errors = camera_errors(self._cameras, disturbance, chance.errors)

    def look_for(self, channels: Collection[str] | None) -> None:  # noqa: B027 (images hold all)
        """Look for regions of other channels from now on; all of them when ``None``."""

    @abstractmethod
    def colors(self) -> tuple[str, ...]:
        """Return the named colours that any camera sees now, without noise."""

    @abstractmethod
    def take(self) -> Exposure:
        """Expose all cameras now."""

    @abstractmethod
    def take_in_the_dark(self) -> Exposure:
        """Expose all cameras now, while there is no light."""

    def close(self) -> None:  # noqa: B027 (ideal ones hold nothing)
        """Free the source of the images."""


def camera_errors(
    cameras: Iterable[str], disturbance: Disturbance, episode: np.random.Generator
) -> dict[str, Pose]:
    """Return true poses of displaced cameras, each in its frame in the robot's model.

    Args:
        cameras: Names of the cameras, in the order of the robot's document.
        disturbance: Sizes of the errors, and the body that they belong to, if any.
        episode: Generator of the errors, if they belong to no body.
    """
    if not (disturbance.camera_position or disturbance.camera_rotation):
        return {}
    body = disturbance.body
    rng = episode if body is None else np.random.default_rng(body)
    # Cameras are drawn in the document's order, so that a body's number determines all of them.
    return {name: _error(disturbance, rng) for name in cameras}


def _error(disturbance: Disturbance, rng: np.random.Generator) -> Pose:
    turned = Pose.turned(_direction(rng), disturbance.camera_rotation)
    return Pose(disturbance.camera_position * _direction(rng), turned.rotation)


def _direction(rng: np.random.Generator) -> Floats:
    """Return a unit vector, shape (3,), drawn uniformly from all directions."""
    # The normal distribution is the same in all directions, unlike a uniform draw from a cube.
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)
