"""Quadratic potential (Section 3.1.1, Eq 3.1).

phi = e . e / 2 with e the difference between reference and feedback in the feedback's type.
Configurations, positions, headings, forces, torques and wrenches subtract. Positions of joints
without limits differ by half a turn at most, unless the robot's document counts their turns.
Orientations differ by a rotation vector in the world frame. Poses differ by translation above
rotation; constellations by two ratios and an angle modulo half a turn. If the tip may turn about
one of its axes, the residual is in the tip's two other axes. Positions, forces and torques may be
compared along some axes of the world frame alone, which leaves the others to other controllers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.potential import Potential, potential
from cbdsl.control.setting import Setting
from cbdsl.kinematics.rotation import align, log_between
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled
from cbdsl.program.controller import AlongNormals, Controller


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the spring of a controller."""
    if controller.axes is not None:
        return along_axes(controller.axes, controller.feedback.type.factors)
    if controller.feedback.type.name == "configuration" and setting.circular.any():
        return circular(setting.circular)
    return spring(controller.feedback.type.name, _size(controller))


def circular(joints: NDArray[np.bool_]) -> Potential:
    """Return the spring of joint positions that takes the shorter way round.

    Args:
        joints: True for joints without limits, whose whole turns do not count, shape (n,).
    """
    periods = np.where(joints, 2.0 * np.pi, np.inf)
    return Potential(circular_difference, len(joints), parameters=periods, identity=True)


def along_axes(axes: Sequence[int], factors: int = 1) -> Potential:
    """Return the spring along some axes of the world frame, for each of several vectors (3,)."""
    chosen = [3 * factor + axis for factor in range(factors) for axis in axes]
    return Potential(chosen_difference, len(chosen), parameters=np.array(chosen, dtype=float))


def spring(kind: str, size: int, free_axis: str | None = None) -> Potential:
    """Return the spring of a type.

    Args:
        kind: Name of the feedback's type.
        size: Number of its components that are compared.
        free_axis: Axis of the tip, ``x``, ``y`` or ``z``, that is aligned with the reference's
            while the tip may turn about it; ``None`` for none.
    """
    if free_axis is None:
        function = {
            "orientation": rotation_difference,
            "pose": pose_difference,
            "constellation": constellation_difference,
        }.get(kind)
        return Potential(function or difference, size, identity=True)
    function = axis_difference if kind == "orientation" else pose_axis_difference
    return Potential(function, size - 1, parameters=np.array([float("xyz".index(free_axis))]))


def _size(controller: Controller) -> int:
    kind = controller.feedback.type
    return kind.factors if isinstance(controller.reference, AlongNormals) else kind.size


@potential
def difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the square of the difference."""
    phi = 0.0
    for i in range(len(residual)):
        residual[i] = reference[i] - value[i]
        phi += 0.5 * residual[i] * residual[i]
    return phi


@potential
def circular_difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared difference modulo a period; parameters: the periods, rad."""
    for i in range(len(residual)):
        residual[i] = reference[i] - value[i]
        if math.isfinite(parameters[i]):
            residual[i] -= parameters[i] * round(residual[i] / parameters[i])
    return _half_square(residual)


@potential
def chosen_difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared difference of some components; parameters: their indices."""
    for i in range(len(residual)):
        component = int(parameters[i])
        residual[i] = reference[component] - value[component]
        slope[i, component] = 1.0
    return _half_square(residual)


@potential
def rotation_difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the square of the angle between two orientations."""
    log_between(value, reference, residual)
    return _half_square(residual)


@potential
def pose_difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squares of the distance and of the angle between two poses."""
    for i in range(3):
        residual[i] = reference[i] - value[i]
    log_between(value[3:], reference[3:], residual[3:])
    return _half_square(residual)


@potential
def constellation_difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared differences of two ratios and of an angle modulo half a turn."""
    for i in range(3):
        residual[i] = reference[i] - value[i]
    residual[2] -= np.pi * np.round(residual[2] / np.pi)
    return _half_square(residual)


@potential
def axis_difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared angle between an axis of two orientations; parameter: the axis."""
    _compare_axes(value, reference, int(parameters[0]), residual, slope)
    return _half_square(residual)


@potential
def pose_axis_difference(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared distance of two poses, plus that of the angle of an axis."""
    for i in range(3):
        residual[i] = reference[i] - value[i]
        slope[i, i] = 1.0
    axis = int(parameters[0])
    _compare_axes(value[3:], reference[3:], axis, residual[3:], slope[3:, 3:])
    return _half_square(residual)


@compiled
def _compare_axes(
    rotation: Floats, wanted: Floats, axis: int, residual: Floats, slope: Floats
) -> None:
    """Write the turn from an axis to its desired direction, along the tip's two other axes."""
    for i in range(2):
        for k in range(3):
            slope[i, k] = rotation[(axis + 1 + i) % 3 + 3 * k]
    turn = align(rotation[axis::3], wanted[axis::3], slope[0])
    for i in range(2):
        residual[i] = slope[i, 0] * turn[0] + slope[i, 1] * turn[1] + slope[i, 2] * turn[2]


@compiled
def _half_square(residual: Floats) -> float:
    phi = 0.0
    for i in range(len(residual)):
        phi += 0.5 * residual[i] * residual[i]
    return phi
