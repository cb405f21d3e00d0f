"""Visible robot: links of its URDF, their parents and their shapes."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cbdsl.kinematics.quaternion import product, quaternion_about, turned
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.meshes.mesh_file import find_mesh
from cbdsl.robot.meshes.mesh_reader import Mesh
from cbdsl.robot.meshes.simplified_mesh import read_simplified
from cbdsl.robot.urdf import UrdfJoint, UrdfModel, UrdfOrigin, UrdfShape
from cbdsl.robot.urdf_reader import parse_urdf
from cbdsl.yaml_text.library import shipped

Numbers = tuple[float, ...]


class LinkShape(NamedTuple):
    """Visible part of a link.

    Attributes:
        shape: ``ball``, ``box``, ``cylinder`` or ``mesh``.
        size: Radius of a ball, edge lengths of a box, radius and height along z of a cylinder, m;
            empty for a mesh.
        position: Position in the link's frame, m.
        quaternion: Orientation in the link's frame, as (x, y, z, w).
        color: Red, green and blue, each from 0 to 1.
        mesh: Triangles of a mesh.
    """

    shape: str
    size: Numbers
    position: Numbers
    quaternion: Numbers
    color: Numbers
    mesh: Mesh | None = None


_GREY = (0.7, 0.7, 0.7)
_KINDS = {"revolute": "turn", "continuous": "turn", "prismatic": "slide"}


class DrawnLink(NamedTuple):
    """Link, with the joint that connects it to its parent.

    Attributes:
        name: Name of the link.
        parent: Index of the parent link, -1 for the root, which is at the world's origin.
        position, quaternion: Pose of the joint in the parent link's frame, m and (x, y, z, w).
        motion: ``turn``, ``slide`` or ``fixed``.
        axis: Axis of the joint, in its own frame.
        column: Index of the recorded joint that moves it, -1 for none.
        ratio: Angle of this joint per angle of the recorded one.
        offset: Angle of this joint when the angle of the recorded one is 0.
        shapes: Visible shapes of the link.
    """

    name: str
    parent: int
    position: Numbers
    quaternion: Numbers
    motion: str
    axis: Numbers
    column: int
    ratio: float
    offset: float
    shapes: tuple[LinkShape, ...]


def read_links(
    robot: Mapping[str, Any],
    joints: Sequence[str],
    *,
    is_recorded: bool = True,
    with_shapes: bool = True,
) -> list[DrawnLink]:
    """Return the links of a recorded robot, each after its parent.

    If no shape of the robot can be shown, the links are a skeleton.

    Args:
        robot: Robot as recorded: ``urdf`` (text), ``folder`` (search path of meshes) and
            ``couplings``.
        joints: Names of the recorded joints.
        is_recorded: True if a recording states the location of meshes. It may come from elsewhere,
            so that only meshes from nearby folders are shown.
        with_shapes: False for poses alone, without the visible shapes.
    """
    folder = Path(robot["folder"])
    model = parse_urdf(robot["urdf"], folder / "model.urdf")
    above = {joint.child: joint for joint in model.joints.values()}
    seen = {
        name: tuple(_shapes(body.visuals, folder, is_recorded)) if with_shapes else ()
        for name, body in model.bodies.items()
    }
    # One visible shape suffices. Links without shapes, such as frames of tools, then stay
    # invisible.
    shown = seen if any(seen.values()) else skeleton(model.joints.values())
    links: list[DrawnLink] = []
    places: dict[str, int] = {}
    # Parents precede their children, so that `places` has the parent of each joint.
    for name in _outwards(model, above):
        shapes = shown.get(name, ())
        places[name] = len(links)
        joint = above.get(name)
        if joint is None:
            root = UrdfOrigin()
            fixed = ("fixed", (0, 0, 1), -1, 1.0, 0.0)
            links.append(DrawnLink(name, -1, root.xyz, root.quaternion, *fixed, shapes))
            continue
        links.append(
            DrawnLink(
                name,
                places[joint.parent],
                joint.origin.xyz,
                joint.origin.quaternion,
                _KINDS.get(joint.kind, "fixed"),
                joint.axis,
                *_driven(joint, robot["couplings"], joints, model.rests.get(joint.name, 0.0)),
                shapes,
            )
        )
    return links


def _outwards(model: UrdfModel, above: Mapping[str, UrdfJoint]) -> Iterator[str]:
    """Yield the links' names, from the root outwards."""
    below: dict[str, list[str]] = {}
    for name, joint in above.items():
        below.setdefault(joint.parent, []).append(name)
    waiting = [name for name in model.bodies if name not in above]
    while waiting:
        name = waiting.pop(0)
        yield name
        waiting += below.get(name, [])


def _driven(
    joint: UrdfJoint, couplings: Mapping[str, Any], joints: Sequence[str], rest: float
) -> tuple[int, float, float]:
    """Return the recorded joint that moves a joint, its ratio and its offset."""
    if joint.name in joints:
        return joints.index(joint.name), 1.0, 0.0
    if joint.name in couplings:
        follows, ratio, *offset = couplings[joint.name]
        return joints.index(follows), float(ratio), float(*offset)
    # Joints that are neither recorded nor coupled, such as fixed ones, stay at their rest position.
    return -1, 1.0, rest


def _is_nearby(file: Path) -> bool:
    """Return whether a recording may name a file: below the current or an installed folder.

    Otherwise a page that is shared could contain files that a hostile recording names elsewhere.
    """
    packages = os.environ.get("ROS_PACKAGE_PATH", "").split(":")
    roots = (Path.cwd(), shipped(), Path(sys.prefix), *(Path(each) for each in packages if each))
    return any(file.resolve().is_relative_to(root.resolve()) for root in roots)


def _shapes(visuals: Sequence[UrdfShape], folder: Path, is_recorded: bool) -> Iterator[LinkShape]:
    """Yield the shapes of a link that can be shown, without missing meshes."""
    for visual in visuals:
        kind, size, mesh = visual.kind, visual.size, None
        if kind == "mesh":
            file = find_mesh(visual.file, folder)
            if file is not None and is_recorded and not _is_nearby(file):
                file = None
            mesh = None if file is None else read_simplified(file, size)
            if mesh is None:
                continue
            # The size of a mesh in URDF is its scale, which `read_simplified` has applied.
            size = ()
        # Pages draw no capsules; a cylinder lacks the rounded ends alone.
        kind = "cylinder" if kind == "capsule" else kind
        at = visual.origin
        yield LinkShape(kind, size, at.xyz, at.quaternion, visual.color or _GREY, mesh)


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
    return {link: tuple(_bone_shapes(own, radius)) for link, own in below.items()}


def _bone_shapes(joints: Iterable[UrdfJoint], radius: float) -> Iterator[LinkShape]:
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


def placed(link: DrawnLink, positions: Floats) -> tuple[Floats, Floats]:
    """Return the position and the quaternion (x, y, z, w) of a link in the frame of its parent.

    Args:
        link: The link.
        positions: Recorded joint positions, rad or m, shape (n,).
    """
    angle = link.offset + (link.ratio * positions[link.column] if link.column >= 0 else 0.0)
    place, turn = np.array(link.position, dtype=float), np.array(link.quaternion, dtype=float)
    # URDF allows axes of any length. A zero axis stays zero instead of NaN.
    axis = np.array(link.axis, dtype=float)
    axis /= np.linalg.norm(axis) or 1.0
    # The motion of the joint follows its constant origin. Its axis is therefore in the turned
    # frame.
    if link.motion == "slide":
        return place + turned(turn, axis * angle), turn
    if link.motion == "turn":
        return place, product(turn, quaternion_about(axis, angle))
    return place, turn
