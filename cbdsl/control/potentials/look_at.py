"""Potential of pointing an axis of the tip at a point (after Eq 3.1).

phi = theta^2 / 2 with theta the angle between the axis and the line from the tip to the point. The
residual is the turn from the axis to the line, in the tip's two other axes. The tip may turn about
the line of sight and move along it. Motion across the line changes the angle more if the point is
nearer.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.potential import Potential, potential
from cbdsl.control.setting import Setting
from cbdsl.kinematics.rotation import align
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Controller

# Smallest distance of a point that has a direction from the tip, m.
_NEAREST = 1e-6


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the pointing potential of a controller's tip, by default along its z axis."""
    return look_at(controller.free_axis or "z")


def look_at(axis: str) -> Potential:
    """Return the pointing potential along an axis of the tip, ``x``, ``y`` or ``z``."""
    parameters = np.array([float("xyz".index(axis))])
    return Potential(view, 2, parameters=parameters, refuse=_refuse)


def _refuse(value: Floats, reference: Floats) -> str:
    return "the point to look at is where the tip is"


@potential
def view(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared angle between an axis of a pose and a point; parameter: the axis.

    The point is the first three components of the reference.
    """
    axis, line = int(parameters[0]), np.empty(3)
    for i in range(3):
        line[i] = reference[i] - value[i]
    distance = math.sqrt(line[0] ** 2 + line[1] ** 2 + line[2] ** 2)
    if not distance > _NEAREST:
        return math.nan
    for i in range(3):
        line[i] /= distance
    rotation = value[3:]
    # Turns about the tip's two other axes s, and equivalent translations along s x line.
    for i in range(2):
        for k in range(3):
            slope[i, 3 + k] = rotation[(axis + 1 + i) % 3 + 3 * k]
        for k in range(3):
            j, m = (k + 1) % 3, (k + 2) % 3
            slope[i, k] = (slope[i, 3 + j] * line[m] - slope[i, 3 + m] * line[j]) / distance
    turn = align(rotation[axis::3], line, slope[0, 3:])
    phi = 0.0
    for i in range(2):
        for k in range(3):
            residual[i] += slope[i, 3 + k] * turn[k]
        phi += 0.5 * residual[i] * residual[i]
    return phi
