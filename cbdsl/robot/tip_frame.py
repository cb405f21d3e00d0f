"""Tips: the frame that a row of joints is likely to act with."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from cbdsl.robot.mesh_file import find_mesh
from cbdsl.robot.urdf import Numbers, UrdfError, UrdfJoint, UrdfModel, UrdfShape

# Names of frames that models have for what acts, the best first, and for what does not.
_ACTING = (
    re.compile(r"grasp|tcp|(^|_)(tool|tool0|eef|ee|ee_link|end_effector)($|_)", re.IGNORECASE),
    re.compile(r"tip$|foot|toe|sole", re.IGNORECASE),
)
_SENSING = re.compile(
    r"camera|optical|imu|laser|lidar|scan|sensor|gyro|accel|inertia|_com$|base$", re.IGNORECASE
)
_DEEPEST = 200  # joints in a row: bounds the walk where a model has a loop
# A frame that is nearer to the last joint than this may as well be at it, m.
_NEAR = 0.01


def acting_link(branches: Mapping[str, Sequence[UrdfJoint]], link: str) -> str:
    """The link that acts, among those that are fixed to one, by its name or by how far out it is.

    Args:
        branches: joints by the link that they leave from.
        link: the one that the last joint moves.
    """
    attached = list(_attached(branches, link, 0))
    for pattern in _ACTING:
        named = [each for each in attached if pattern.search(each)]
        if named:
            return named[-1]
    if any(not joint.fixed for each in (link, *attached) for joint in branches.get(each, [])):
        return link  # where a hand begins that has joints of its own
    return _end(branches, link)


def tip_offset(model: UrdfModel, joint: UrdfJoint, link: str) -> Numbers:
    """Where the far end of a link is, m, which is the joint's own; nothing where frames say it.

    It is where its shapes reach farthest past its frame, along one of its axes.
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


_Box = list[tuple[float, float]]


def _box(model: UrdfModel, shape: UrdfShape) -> _Box | None:
    """Bounds of a shape along the axes of its link, if they can be told."""
    corners = _corners(model, shape)
    if not corners:
        return None
    rotation, place = shape.origin.rotation, shape.origin.xyz
    return [_span(row, at, corners) for row, at in zip(rotation, place, strict=True)]


def _span(row: Sequence[float], at: float, corners: Iterable[Numbers]) -> tuple[float, float]:
    values = [at + math.fsum(a * b for a, b in zip(row, each, strict=True)) for each in corners]
    return min(values), max(values)


def _corners(model: UrdfModel, shape: UrdfShape) -> list[Numbers]:
    """Corners of a shape or of a box around it, in the frame of the shape, m."""
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
    """Corners of the box around a mesh; none where it is not there, or cannot be read here."""
    file = find_mesh(name, model.path.parent)
    try:
        from cbdsl.robot.mesh_reader import MeshError, read_mesh_file
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
    """The links that are fixed to one, those nearest to it first in each row, without sensors."""
    if depth >= _DEEPEST:
        return
    for joint in branches.get(link, []):
        if joint.fixed and not _SENSING.search(joint.child):
            yield joint.child
            yield from _attached(branches, joint.child, depth + 1)


def _end(branches: Mapping[str, Sequence[UrdfJoint]], link: str) -> str:
    """The last link that is fixed to another in a row."""
    for _ in range(_DEEPEST):
        leaving = [each for each in branches.get(link, []) if not _SENSING.search(each.child)]
        if len(leaving) != 1:
            break
        link = leaving[0].child
    return link
