"""Samples: messages of a robot, independent of the transport that carried them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.channels import Regions


class JointSample(NamedTuple):
    """Joint states.

    Attributes:
        driver: Name of the driver.
        stamp: Time of the measurement by the robot's clock, s since the epoch.
        names: Joints, by their names in the driver's messages.
        positions: Positions, rad or m, one per joint.
        velocities: Velocities, rad/s or m/s, one per joint; empty if the robot measures none.
        efforts: Efforts, N m or N, one per joint; empty if the robot measures none.
        source: Number of the publisher; 0 if the transport has none.
    """

    driver: str
    stamp: float
    names: tuple[str, ...]
    positions: tuple[float, ...]
    velocities: tuple[float, ...] = ()
    efforts: tuple[float, ...] = ()
    source: int = 0


class WrenchSample(NamedTuple):
    """Wrench of a load cell.

    Attributes:
        driver: Name of the driver.
        cell: Hand and finger.
        stamp: Time of the measurement by the robot's clock, s since the epoch.
        frame: Link in whose axes the wrench is given.
        wrench: Force and torque exerted on the world, N and N m, shape (6,).
    """

    driver: str
    cell: tuple[str, str]
    stamp: float
    frame: str
    wrench: tuple[float, ...]


class ImageSample(NamedTuple):
    """Image of a camera.

    Attributes:
        driver: Name of the driver.
        camera: Name of the camera.
        stamp: Time of the exposure by the robot's clock, s since the epoch.
        image: RGB, shape (height, width, 3), top row first; ``None`` in an unknown encoding.
        encoding: Encoding of the message.
    """

    driver: str
    camera: str
    stamp: float
    image: NDArray[np.uint8] | None
    encoding: str = "rgb8"


class RegionsSample(NamedTuple):
    """Segmented regions of a camera's image, by channel, the largest region first."""

    driver: str
    camera: str
    stamp: float
    regions: dict[str, Regions]


class CameraSample(NamedTuple):
    """Intrinsic parameters of a camera: image size and focal lengths, px."""

    driver: str
    camera: str
    width: int
    height: int
    focal_lengths: tuple[float, float]


class DescriptionSample(NamedTuple):
    """URDF of the robot as it describes itself."""

    driver: str
    urdf: str


class StopSample(NamedTuple):
    """State of the emergency stop.

    Attributes:
        driver: Name of the driver.
        pressed: True if the stop is pressed.
        source: Number of the publisher; 0 if the transport has none.
    """

    driver: str
    pressed: bool
    source: int = 0


class PublishersSample(NamedTuple):
    """Living publishers of the emergency stop.

    Attributes:
        driver: Name of the driver.
        names: Process of each publisher, such as "process 4711", by number.
    """

    driver: str
    names: Mapping[int, str]


class FaultSample(NamedTuple):
    """Fault that the transport found: a peer that ended, another commander, a broken message.

    Attributes:
        driver: Name of the driver.
        cause: Sentence without a full stop.
    """

    driver: str
    cause: str


Sample = (
    JointSample
    | WrenchSample
    | ImageSample
    | RegionsSample
    | CameraSample
    | DescriptionSample
    | StopSample
    | PublishersSample
    | FaultSample
)


class Command(NamedTuple):
    """References of a driver's joints.

    Attributes:
        names: Joints, by their names in the driver's messages.
        positions: Positions, rad or m, one per joint.
        horizon: Time until the references are reached, s.
        stamp: Time at which the references were decided, s since the epoch. A controller refuses
            those whose horizon is over, as of a program that was suspended before it sent them.
            0 means immediately.
    """

    names: tuple[str, ...]
    positions: tuple[float, ...]
    horizon: float
    stamp: float
