"""Tips: the probable acting frame of serial joints."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from cbdsl.robot.meshes.mesh_file import find_mesh
from cbdsl.robot.urdf import Numbers, UrdfError, UrdfJoint, UrdfModel, UrdfShape

# Name patterns of acting frames, the best first, and of frames that do not act.
_ACTING = (
    re.compile(r"grasp|tcp", re.IGNORECASE),
    re.compile(r"(^|_)tool0($|_)", re.IGNORECASE),
    re.compile(r"(^|_)(tool|eef|ee|ee_link|end_effector)($|_)", re.IGNORECASE),
    re.compile(r"tip$|foot|toe|sole", re.IGNORECASE),
)
_SENSING = re.compile(
    r"camera|optical|imu|laser|lidar|scan|sensor|gyro|accel|inertia|_com$", re.IGNORECASE
)
_DEEPEST = 200  # joints in series; bounds the walk if a model has a loop
# Distance below which a frame counts as at the last joint, m.
_NEAR = 0.01


def acting_links(
    branches: Mapping[str, Sequence[UrdfJoint]], link: str, end: str = ""
) -> tuple[str, tuple[str, ...]]:
    """Return the acting link among those fixed to a link, and others with names of acting links.

    The acting link has the best name, or else the largest distance.

    Args:
        branches: Joints by their parent link.
        link: Link that the last joint moves.
        end: Link fixed to it that carries other moving joints, such as the base of a hand.
    """
    attached = list(_attached(branches, link, 0))
    # The outermost frame of a series comes last, as the tool centre point behind the flange.
    named = [each for name in _ACTING for each in reversed(attached) if name.search(each)]
    if named:
        return named[0], tuple(dict.fromkeys(each for each in named[1:] if each != named[0]))
    if any(not joint.fixed for each in (link, *attached) for joint in branches.get(each, [])):
        return end or link, ()
    return _end(branches, link), ()


def is_acting(link: str) -> bool:
    """Return whether a link has the name of an acting frame."""
    return any(name.search(link) for name in _ACTING)


# Models of simple robots often end at the last joint, without a frame at the far end. Its position
# is then estimated from the bounding box of the last link's shapes. The axis is chosen along which
# the centre of the box is farthest from the joint. Along it, the farther end is the tip. No
# estimate is made for a box around the joint, such as that of a wheel, or for an end within 1 cm of
# it. A tip aside of the axes of the frame is missed.
def tip_offset(model: UrdfModel, joint: UrdfJoint, link: str) -> Numbers:
    """Return the far end of a joint's own link, m, or zero if frames define the tip.

    The end is the farthest extent of its shapes from its frame, along one of its axes.
    """
    nothing = (0.0, 0.0, 0.0)
    if link != joint.child or any(each.parent == link for each in model.joints.values()):
        return nothing
    try:
        body = model.bodies[link]
    except UrdfError:
        return nothing
    boxes = [box for box in (_box(model, each) for each in body.collisions or body.visuals) if box]
    if not boxes:
        return nothing
    spans = [[box[axis] for box in boxes] for axis in range(3)]
    ends = [(min(low for low, _ in each), max(high for _, high in each)) for each in spans]
    axis = max(range(3), key=lambda each: abs(ends[each][0] + ends[each][1]))
    end = max(ends[axis], key=abs)
    if abs(end) < _NEAR or abs(sum(ends[axis])) < _NEAR:
        return nothing
    x, y, z = (round(end, 3) if each == axis else 0.0 for each in range(3))
    return x, y, z


def shape_centre(model: UrdfModel, link: str) -> Numbers:
    """Return the centre of the box around a link's collision shapes, in its frame, m."""
    corners = shape_corners(model, link)
    if not corners:
        return (0.0, 0.0, 0.0)
    x, y, z = ((min(values) + max(values)) / 2 for values in zip(*corners, strict=True))
    return x, y, z


def shape_corners(model: UrdfModel, link: str) -> list[Numbers]:
    """Return the corners of boxes around a link's collision shapes, in its frame, m."""
    boxes = (_box(model, each) for each in model.bodies[link].collisions)
    return [corner for box in boxes if box for corner in itertools.product(*box)]


_Box = list[tuple[float, float]]


def _box(model: UrdfModel, shape: UrdfShape) -> _Box | None:
    """Return the bounds of a shape along the axes of its link, if they are known."""
    corners = _corners(model, shape)
    if not corners:
        return None
    rotation, place = shape.origin.rotation, shape.origin.xyz
    return [_span(row, at, corners) for row, at in zip(rotation, place, strict=True)]


def _span(row: Sequence[float], at: float, corners: Iterable[Numbers]) -> tuple[float, float]:
    values = [at + math.fsum(a * b for a, b in zip(row, each, strict=True)) for each in corners]
    return min(values), max(values)


def _corners(model: UrdfModel, shape: UrdfShape) -> list[Numbers]:
    """Return the corners of a shape or of a box around it, in the frame of the shape, m."""
    match shape.kind, shape.size:
        case "box", (x, y, z):
            half = (x / 2, y / 2, z / 2)
        case "ball", (radius,):
            half = (radius, radius, radius)
        case (("cylinder" | "capsule"), (radius, height)):
            half = (radius, radius, height / 2)
        case "mesh", scale:
            return _mesh_corners(model, shape.file, scale)
        case _:
            return []
    signs = ((a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1))
    return [(a * half[0], b * half[1], c * half[2]) for a, b, c in signs]


def _mesh_corners(model: UrdfModel, name: str, scale: Numbers) -> list[Numbers]:
    """Return the corners of the box around a mesh; none if it is missing or unreadable."""
    file = find_mesh(name, model.path.parent)
    try:
        from cbdsl.robot.meshes.mesh_reader import MeshError, read_mesh_file
    except ImportError:
        return []
    if file is None:
        return []
    try:
        corners = read_mesh_file(file, scale).corners
    except MeshError:
        return []
    low, high = corners.min(axis=0), corners.max(axis=0)
    return [
        (float(x), float(y), float(z))
        for x in (low[0], high[0])
        for y in (low[1], high[1])
        for z in (low[2], high[2])
    ]


def _attached(branches: Mapping[str, Sequence[UrdfJoint]], link: str, depth: int) -> Iterator[str]:
    """Yield the links that are fixed to a link, nearest first in each series, without sensors."""
    if depth >= _DEEPEST:
        return
    for joint in branches.get(link, []):
        if joint.fixed and not _SENSING.search(joint.child):
            yield joint.child
            yield from _attached(branches, joint.child, depth + 1)


def _end(branches: Mapping[str, Sequence[UrdfJoint]], link: str) -> str:
    """Return the last link of a series that is fixed to a link."""
    for _ in range(_DEEPEST):
        leaving = [each for each in branches.get(link, []) if not _SENSING.search(each.child)]
        if len(leaving) != 1:
            break
        link = leaving[0].child
    return link
