"""Skeleton of a robot without visible shapes: its joints as balls, joined by rods."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from cbdsl.reporting.link_shape import LinkShape, Numbers
from cbdsl.robot.urdf import UrdfJoint

_COLOR = (0.35, 0.5, 0.65)
# Thickness of the rods relative to the longest, so that the skeleton suits any size of robot.
_SLENDERNESS = 0.06


def skeleton(joints: Iterable[UrdfJoint]) -> Mapping[str, tuple[LinkShape, ...]]:
    """Return shapes of each link by name: a rod to every joint of a child, and a ball there.

    Args:
        joints: All joints of a model.
    """
    below: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        below.setdefault(joint.parent, []).append(joint)
    longest = max((joint.length for own in below.values() for joint in own), default=0.0)
    radius = _SLENDERNESS * (longest or 1.0)
    return {link: tuple(_shapes(own, radius)) for link, own in below.items()}


def _shapes(joints: Iterable[UrdfJoint], radius: float) -> Iterator[LinkShape]:
    upright = (0.0, 0.0, 0.0, 1.0)
    for joint in joints:
        end = joint.origin.xyz
        size = 1.3 if not joint.fixed else 1.0
        yield LinkShape("ball", (size * radius,), end, upright, _COLOR)
        if joint.length > 0.0:
            middle = tuple(value / 2 for value in end)
            rod = (radius / 2, joint.length)
            yield LinkShape("cylinder", rod, middle, _along(end), _COLOR)


def _along(direction: Numbers) -> Numbers:
    """Return the quaternion (x, y, z, w) of the shortest turn from the z axis to a direction."""
    # The shortest turn from z to a unit vector d is the quaternion (z x d, 1 + z . d), normalized.
    # Its norm is sqrt(2 (1 + z . d)).
    x, y, z = (value / math.hypot(*direction) for value in direction)
    # Opposite to z, the axis is arbitrary: half a turn about x.
    if z < -1 + 1e-9:
        return (1.0, 0.0, 0.0, 0.0)
    length = math.sqrt(2 * (1 + z))
    return (-y / length, x / length, 0.0, length / 2)
