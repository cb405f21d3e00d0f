"""Weights: the torques with which joints bear the links of a model at rest."""

# Model: a joint bears the weight m g of all links that it moves, at their common centre of mass c.
# With its axis u through p, it needs the torque u . ((c - p) x (0, 0, m g)) if it turns, and the
# force u . (0, 0, m g) if it slides. The root is level, as in all engines.

from __future__ import annotations

import math
from collections.abc import Mapping

from cbdsl.robot.link_place import ROOT, Frame, dot, link_frame, moved, position_of, within
from cbdsl.robot.urdf import UrdfJoint, UrdfModel

_GRAVITY = 9.81


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
    frames = {start: ROOT if not above else link_frame(model, positions, start)}
    joints = [*model.beyond(start)]
    carried: dict[str, list[float]] = {}
    for joint in joints:
        frames[joint.child] = moved(
            frames[joint.parent], joint, position_of(model, joint, positions)
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


def _moment(model: UrdfModel, link: str, frame: Frame) -> list[float]:
    """Return the mass of a link, kg, and its product with the centre's position, kg m."""
    inertial = model.bodies[link].inertial
    if inertial is None:
        return [0.0, 0.0, 0.0, 0.0]
    centre = within(frame, ROOT[0], inertial.origin.xyz)[1]
    return [inertial.mass, *(inertial.mass * each for each in centre)]


def _torque(joint: UrdfJoint, frame: Frame, mass: float, x: float, y: float) -> float:
    """Return the effort that bears a mass, whose centre is at (x, y) / mass."""
    rows, place = frame
    norm = math.hypot(*joint.axis) or 1.0
    ux, uy, uz = (dot(row, joint.axis) / norm for row in rows)
    if joint.slides:
        return uz * mass * _GRAVITY
    dx, dy = x - mass * place[0], y - mass * place[1]
    return _GRAVITY * (ux * dy - uy * dx)
