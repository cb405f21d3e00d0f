"""What a URDF says of the robot's links and joints besides their tree: shapes and speeds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.shape import Shape

_AXES = np.eye(3)


class Solid(NamedTuple):
    """A shape in the frame of its link."""

    shape: Shape
    pose: Pose


class Links:
    """The links of a URDF model.

    Attributes:
        solids: the balls, boxes and cylinders of each link that collide; its meshes are left out.
        speeds: the speed limit of each joint, rad/s, infinite without one.
    """

    def __init__(self, urdf: Path) -> None:
        root = ElementTree.parse(urdf).getroot()
        self.solids: Mapping[str, tuple[Solid, ...]] = {
            link.get("name", ""): tuple(_solids(link)) for link in root.findall("link")
        }
        self.speeds: Mapping[str, float] = {
            joint.get("name", ""): _speed(joint) for joint in root.findall("joint")
        }


def _speed(joint: ElementTree.Element) -> float:
    limit = joint.find("limit")
    speed = math.inf if limit is None else float(limit.get("velocity", "inf"))
    return speed or math.inf


def _solids(link: ElementTree.Element) -> Iterator[Solid]:
    for collision in link.findall("collision"):
        shape = _shape(collision.find("geometry"))
        if shape is not None:
            yield Solid(shape, origin(collision.find("origin")))


def _shape(geometry: ElementTree.Element | None) -> Shape | None:
    for element in geometry if geometry is not None else ():
        if element.tag == "sphere":
            return Shape.ball(float(element.get("radius", "0")))
        if element.tag == "cylinder":
            radius, length = (float(element.get(key, "0")) for key in ("radius", "length"))
            return Shape.cylinder(radius, length)
        if element.tag == "box":
            x, y, z = (edge / 2 for edge in numbers(element.get("size")))
            return Shape("box", (x, y, z))
    return None


def origin(element: ElementTree.Element | None) -> Pose:
    """What an ``<origin>`` says; where there is none, no displacement."""
    if element is None:
        return Pose(np.zeros(3), np.eye(3))
    roll, pitch, yaw = numbers(element.get("rpy"))
    turned = Pose.turned(_AXES[2], yaw) @ Pose.turned(_AXES[1], pitch) @ Pose.turned(_AXES[0], roll)
    return Pose(np.array(numbers(element.get("xyz"))), turned.rotation)


def numbers(text: str | None, absent: str = "0 0 0") -> list[float]:
    """The numbers of an attribute, or those that stand for an absent one."""
    return [float(word) for word in (text or absent).split()]
