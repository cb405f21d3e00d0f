"""Places of links at given positions of the joints, without NumPy.

Documents are checked without NumPy, which the base installation lacks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from cbdsl.robot.urdf import UrdfJoint, UrdfModel

#: Parts of a joint's range at its ends that proposed postures avoid.
OUTER = 0.1
#: Fewest joints that move a tip in three directions.
PLACING = 3
# Rotation by rows, and position, m.
Rows = tuple[tuple[float, ...], ...]
Frame = tuple[Rows, tuple[float, ...]]
ROOT: Frame = (((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))


def at_first(joint: UrdfJoint) -> float:
    """Return zero if it is well within a joint's range, else the middle of it; rad or m.

    Without such a range, return the position nearest to zero within the limits.
    """
    span = joint.upper - joint.lower
    if not 0.0 < span < math.inf:
        return joint.rest
    margin = OUTER * span
    if joint.lower + margin <= 0.0 <= joint.upper - margin:
        return 0.0
    middle = (joint.lower + joint.upper) / 2
    whole = math.radians(round(math.degrees(middle)))
    is_angle = not joint.slides and joint.lower + margin <= whole <= joint.upper - margin
    return whole if is_angle else round(middle, 4)


def position_of(model: UrdfModel, joint: UrdfJoint, positions: Mapping[str, float]) -> float:
    """Return a joint's position, rad or m: as given, as its leader moves it, or at rest."""
    mimic = joint.mimic
    if joint.name in positions:
        return positions[joint.name]
    if mimic is not None and mimic.joint in positions:
        return mimic.ratio * positions[mimic.joint] + mimic.offset
    return model.rests.get(joint.name, 0.0)


def link_frame(model: UrdfModel, positions: Mapping[str, float], link: str) -> Frame:
    """Return the frame of a link in the root's; joints without a position rest."""
    frame = ROOT
    for joint in reversed(model.way(link)):
        frame = moved(frame, joint, position_of(model, joint, positions))
    return frame


def moved(parent: Frame, joint: UrdfJoint, position: float) -> Frame:
    """Return the frame of the link that a joint moves."""
    rows, place = within(parent, joint.origin.rotation, joint.origin.xyz)
    if not position:
        return rows, place
    x, y, z = joint.axis
    norm = math.hypot(x, y, z) or 1.0
    x, y, z = x / norm, y / norm, z / norm
    if joint.slides:
        return rows, within((rows, place), ROOT[0], [position * each for each in (x, y, z)])[1]
    # Rotation about an axis by Rodrigues' formula.
    c, s = math.cos(position), math.sin(position)
    k = 1.0 - c
    turn = (
        (c + x * x * k, x * y * k - z * s, x * z * k + y * s),
        (y * x * k + z * s, c + y * y * k, y * z * k - x * s),
        (z * x * k - y * s, z * y * k + x * s, c + z * z * k),
    )
    return within((rows, place), turn, (0.0, 0.0, 0.0))


def within(frame: Frame, rotation: Rows, place: Iterable[float]) -> Frame:
    """Return a frame, given in another one, in the root's."""
    rows, origin = frame
    columns, place = [*zip(*rotation, strict=True)], [*place]
    return (
        tuple(tuple(dot(row, column) for column in columns) for row in rows),
        tuple(at + dot(row, place) for row, at in zip(rows, origin, strict=True)),
    )


def dot(one: Iterable[float], other: Iterable[float]) -> float:
    """Return the inner product of two vectors."""
    return sum(a * b for a, b in zip(one, other, strict=True))
