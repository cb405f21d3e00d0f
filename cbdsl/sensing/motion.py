"""How a point moves with the joints, from their axes (Eq 3.11 and 3.12); compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.compiled import compiled, compiled_once

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Vector = tuple[float, float, float]


@compiled_once
def point_at(
    x: float,
    y: float,
    z: float,
    origin: Floats,
    rotation: Floats,
    axes: Floats,
    moved: Integers,
    columns: Integers,
    ratios: Floats,
    point: Floats,
    jacobian: Floats,
) -> None:
    """Compute a point of a link, and its Jacobian.

    Args:
        x, y, z: of the point from the link's origin in the link's axes, m.
        origin: of the link, world frame, m, shape (3,).
        rotation: the link's axes as columns, shape (3, 3).
        axes: spatial velocities at the world's origin, linear above angular, per velocity of the
            model's joints, shape (6, nv).
        moved: which of the model's joints move the link, from the root outwards, shape (k,).
        columns: the actuated joint that each of them follows, shape (k,).
        ratios: how far it follows, shape (k,).
        point: becomes its position, world frame, m, shape (3,).
        jacobian: zeros, becomes its linear above angular velocity, world axes, per velocity of the
            n actuated joints, shape (6, n).
    """
    for row in range(3):
        turned = rotation[row, 0] * x + rotation[row, 1] * y + rotation[row, 2] * z
        point[row] = origin[row] + turned
    for i in range(len(moved)):
        twist = _twist(point, axes[:, moved[i]], ratios[i])
        for row in range(6):
            jacobian[row, columns[i]] += twist[row]


@compiled_once
def component_along(rotation: Floats, axis: Floats, vector: Floats) -> float:
    """The component of a vector (3,) along an axis (3,) that is turned by a rotation (3, 3)."""
    along = 0.0
    for row in range(3):
        turned = (
            rotation[row, 0] * axis[0] + rotation[row, 1] * axis[1] + rotation[row, 2] * axis[2]
        )
        along += turned * vector[row]
    return along


@compiled_once
def curvature_at(
    point: Floats,
    axes: Floats,
    moved: Integers,
    columns: Integers,
    ratios: Floats,
    curvature: Floats,
) -> None:
    """Compute the derivative of a point's Jacobian by the joints, as it moves along with them.

    A joint turns the axes and levers of the joints beyond it, and moves the point as it turns
    those before it: of joints i before j, the column of either changes by the other as
    omega_i x v_j; their axes change as omega_i x omega_j, by joint i alone.

    Args:
        point: world frame, m, shape (3,).
        axes, moved, columns, ratios: as above.
        curvature: zeros, shape (rows, n, n), of 3 rows for the linear part alone or 6 for both;
            entry (k, i, j) becomes the change of the Jacobian's entry (k, i) per joint j.
    """
    for i in range(len(moved)):
        first = _twist(point, axes[:, moved[i]], ratios[i])
        for j in range(i, len(moved)):
            second = _twist(point, axes[:, moved[j]], ratios[j])
            one, other = columns[i], columns[j]
            change = _cross(first[3:], second[:3])
            for row in range(3):
                curvature[row, other, one] += change[row]
                if i != j:
                    curvature[row, one, other] += change[row]
            if len(curvature) == 6:
                change = _cross(first[3:], second[3:])
                for row in range(3):
                    curvature[3 + row, other, one] += change[row]


@compiled
def _twist(
    point: Floats, axis: Floats, ratio: float
) -> tuple[float, float, float, float, float, float]:
    """Linear and angular velocity at a point, of a joint that turns by ``ratio``."""
    vx, vy, vz, x, y, z = axis[0], axis[1], axis[2], axis[3], axis[4], axis[5]
    return (
        ratio * (vx + y * point[2] - z * point[1]),
        ratio * (vy + z * point[0] - x * point[2]),
        ratio * (vz + x * point[1] - y * point[0]),
        ratio * x,
        ratio * y,
        ratio * z,
    )


@compiled
def _cross(left: Vector, right: Vector) -> Vector:
    return (
        left[1] * right[2] - left[2] * right[1],
        left[2] * right[0] - left[0] * right[2],
        left[0] * right[1] - left[1] * right[0],
    )
