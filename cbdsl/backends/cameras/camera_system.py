"""The camera system: a robot's cameras, whatever makes their images."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple, Protocol

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


class CameraSystem(Protocol):
    """All cameras of a robot.

    Attributes:
        renderer: what makes the images, for people.
    """

    renderer: str

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
        ...

    def take(self) -> Exposure:
        """Expose all cameras now."""
        ...

    def close(self) -> None:
        """Free what makes the images."""
        ...


def draw_errors(
    robot: RobotDocument, disturbance: Disturbance, rng: np.random.Generator
) -> Mapping[str, Pose]:
    """Errors of the cameras' poses in the frames of their links: none where all are exact.

    An error is a distance in a random direction and an angle about a random axis.
    """
    if not (disturbance.camera_position or disturbance.camera_rotation):
        return {}
    return {name: _error(disturbance, rng) for name in robot.cameras}


def _error(disturbance: Disturbance, rng: np.random.Generator) -> Pose:
    turned = Pose.turned(_direction(rng), disturbance.camera_rotation)
    return Pose(disturbance.camera_position * _direction(rng), turned.rotation)


def _direction(rng: np.random.Generator) -> Floats:
    """A unit vector, shape (3,), drawn evenly from all directions."""
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)
