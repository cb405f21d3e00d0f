"""Readings: values of resources in one tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats


class CameraHeading(NamedTuple):
    """Heading in one camera, of which a heading is made.

    Attributes:
        camera: Number of the camera in the robot document.
        share: Weight of its heading in the value.
        angles: Azimuth and elevation, rad, shape (2,).
    """

    camera: int
    share: float
    angles: Floats


class Reading(NamedTuple):
    """Value and Jacobian of a resource in one tick.

    Attributes:
        value: Value, SI units, shape (m,); an orientation is a rotation matrix, shape (3, 3), and a
            pose a homogeneous transform from tip to world, shape (4, 4).
        jacobian: Change of the value per joint, shape (m, n) over all actuated joints. For an
            orientation, it is the angular velocity in world axes, shape (3, n); for a pose, linear
            above angular velocity, shape (6, n). ``None`` if the joints do not change the value.
        stamp: Count of the measurements, by which repeated values are recognised.
        radius: Apparent radius of a seen object, m.
        measured: False for a force without contact.
        cameras: Headings in the cameras of which a heading is made.
    """

    value: Floats
    jacobian: Floats | None
    stamp: int
    radius: float = 0.0
    measured: bool = True
    cameras: tuple[CameraHeading, ...] = ()


def stacked(readings: Sequence[Reading]) -> Reading:
    """Return the reading of a product: the factors' values and Jacobians, in turn."""
    return Reading(
        np.concatenate([reading.value for reading in readings]),
        np.concatenate([jacobian_of(reading) for reading in readings]),
        max(reading.stamp for reading in readings),
        cameras=tuple([sight for reading in readings for sight in reading.cameras]),
    )


def mean(readings: Sequence[Reading]) -> Reading:
    """Return the mean of readings of the same shape, with the newest stamp."""
    if len(readings) == 1:
        return readings[0]
    first, *others = readings
    # A few sums take a tenth of the time of np.mean.
    value, jacobian = first.value, jacobian_of(first)
    for reading in others:
        value, jacobian = value + reading.value, jacobian + jacobian_of(reading)
    share = 1.0 / len(readings)
    cameras = [
        CameraHeading(s.camera, share * s.share, s.angles)
        for each in readings
        for s in each.cameras
    ]
    stamp = max([each.stamp for each in readings])
    return Reading(share * value, share * jacobian, stamp, cameras=tuple(cameras))


def jacobian_of(reading: Reading) -> Floats:
    """Return the Jacobian of a reading that the joints change."""
    assert reading.jacobian is not None
    return reading.jacobian


def shaped(value: Floats, kind: str) -> Floats:
    """Return a copy of a row's value in the form of a type: an orientation or pose is a matrix."""
    if kind == "orientation":
        return value.reshape(3, 3).copy()
    if kind == "pose":
        return transform(value[3:].reshape(3, 3), value[:3])
    return value.copy()


def transform(rotation: Floats, position: Floats) -> Floats:
    """Return the homogeneous transform (4, 4) of a rotation (3, 3) and a position (3,), m."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose


def flattened(value: Floats, kind: str) -> Floats:
    """Return a value in the form of its row: a pose's position precedes its rotation."""
    if kind == "pose":
        return np.concatenate((value[:3, 3], value[:3, :3].ravel()))
    return value.ravel()
