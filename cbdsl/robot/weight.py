"""Weights: the torques with which joints bear the links of a model at rest."""

# Model: a joint bears the weight m g of all links that it moves, at their common centre of mass c.
# With its axis u through p, it needs the torque u . ((c - p) x (0, 0, m g)) if it turns, and the
# force u . (0, 0, m g) if it slides. The root is level, as in all engines. Documents are checked
# without NumPy, which the base installation lacks, and so is this.

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from cbdsl.robot.urdf import UrdfJoint, UrdfModel

_GRAVITY = 9.81
# Rotation by rows, and position, m.
_Rows = tuple[tuple[float, ...], ...]
_Frame = tuple[_Rows, tuple[float, ...]]
_ROOT: _Frame = (((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))


def weights(model: UrdfModel, positions: Mapping[str, float], above: str = "") -> dict[str, float]:
    """Return the torques, N m, or forces, N, with which joints bear the links that they move.

    Args:
        model: Model of the robot.
        positions: Positions of joints, rad or m; other joints rest, and mimics follow.
        above: Link above the joints of interest; the root if omitted.

    Raises:
        UrdfError: A value of a link is not a number.
    """
    start = above or model.roots[0]
    frames = {start: _ROOT if not above else _place(model, positions, start)}
    joints = [*model.beyond(start)]
    carried: dict[str, list[float]] = {}
    for joint in joints:
        frames[joint.child] = _moved(
            frames[joint.parent], joint, _position(model, joint, positions)
        )
        carried[joint.child] = _moment(model, joint.child, frames[joint.child])
    borne = {}
    # From the ends inwards: each link has all that it carries before its own joint bears it.
    for joint in reversed(joints):
        mass, x, y, z = carried[joint.child]
        if joint.movable:
            borne[joint.name] = _torque(joint, frames[joint.child], mass, x, y)
        if joint.parent in carried:
            inner = carried[joint.parent]
            carried[joint.parent] = [a + b for a, b in zip(inner, (mass, x, y, z), strict=True)]
    return borne


def overloads(
    model: UrdfModel, positions: Mapping[str, float], efforts: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return the joints that cannot bear their links, each with the needed and the largest effort.

    Args:
        model: Model of the robot.
        positions: Positions of joints, rad or m; other joints rest, and mimics follow.
        efforts: Largest efforts of the joints of interest, N m or N.

    Raises:
        UrdfError: A value of a link is not a number.
    """
    # Only the links beyond these joints matter, which saves time for robots with many limbs.
    ways = [[joint.parent for joint in model.way(model.joints[name].child)] for name in efforts]
    shared = frozenset[str]().union(*ways).intersection(*ways)
    borne = weights(model, positions, next(link for link in ways[0] if link in shared))
    return {
        name: (abs(borne[name]), most) for name, most in efforts.items() if abs(borne[name]) > most
    }


def _position(model: UrdfModel, joint: UrdfJoint, positions: Mapping[str, float]) -> float:
    mimic = joint.mimic
    if joint.name in positions:
        return positions[joint.name]
    if mimic is not None and mimic.joint in positions:
        return mimic.ratio * positions[mimic.joint] + mimic.offset
    return model.rests.get(joint.name, 0.0)


def _place(model: UrdfModel, positions: Mapping[str, float], link: str) -> _Frame:
    frame = _ROOT
    for joint in reversed(model.way(link)):
        frame = _moved(frame, joint, _position(model, joint, positions))
    return frame


def _moved(parent: _Frame, joint: UrdfJoint, position: float) -> _Frame:
    """Return the frame of the link that a joint moves."""
    rows, place = _within(parent, joint.origin.rotation, joint.origin.xyz)
    if not position:
        return rows, place
    x, y, z = joint.axis
    norm = math.hypot(x, y, z) or 1.0
    x, y, z = x / norm, y / norm, z / norm
    if joint.slides:
        return rows, _within((rows, place), _ROOT[0], [position * each for each in (x, y, z)])[1]
    # Rotation about an axis by Rodrigues' formula.
    c, s = math.cos(position), math.sin(position)
    k = 1.0 - c
    turn = (
        (c + x * x * k, x * y * k - z * s, x * z * k + y * s),
        (y * x * k + z * s, c + y * y * k, y * z * k - x * s),
        (z * x * k - y * s, z * y * k + x * s, c + z * z * k),
    )
    return _within((rows, place), turn, (0.0, 0.0, 0.0))


def _within(frame: _Frame, rotation: _Rows, place: Iterable[float]) -> _Frame:
    """Return a frame, given in another one, in the root's."""
    rows, origin = frame
    columns, place = [*zip(*rotation, strict=True)], [*place]
    return (
        tuple(tuple(_dot(row, column) for column in columns) for row in rows),
        tuple(at + _dot(row, place) for row, at in zip(rows, origin, strict=True)),
    )


def _dot(one: Iterable[float], other: Iterable[float]) -> float:
    return sum(a * b for a, b in zip(one, other, strict=True))


def _moment(model: UrdfModel, link: str, frame: _Frame) -> list[float]:
    """Return the mass of a link, kg, and its product with the centre's position, kg m."""
    inertial = model.bodies[link].inertial
    if inertial is None:
        return [0.0, 0.0, 0.0, 0.0]
    centre = _within(frame, _ROOT[0], inertial.origin.xyz)[1]
    return [inertial.mass, *(inertial.mass * each for each in centre)]


def _torque(joint: UrdfJoint, frame: _Frame, mass: float, x: float, y: float) -> float:
    """Return the effort that bears a mass, whose centre is at (x, y) / mass."""
    rows, place = frame
    norm = math.hypot(*joint.axis) or 1.0
    ux, uy, uz = (_dot(row, joint.axis) / norm for row in rows)
    if joint.slides:
        return uz * mass * _GRAVITY
    dx, dy = x - mass * place[0], y - mass * place[1]
    return _GRAVITY * (ux * dy - uy * dx)
