"""Rotation vectors: what orientations differ by."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.signal import Floats
from cbdsl.numeric.compiled import compiled_once


def exp(vector: Floats) -> Floats:
    """The rotation matrix (3, 3) of a rotation vector (3,), axis times angle in rad (Rodrigues)."""
    angle = math.hypot(*vector.tolist())
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (vector / angle).tolist()
    turn = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    versine = 2.0 * math.sin(0.5 * angle) ** 2  # 1 - cos, exact for small angles
    rotation: Floats = np.eye(3) + math.sin(angle) * turn + versine * (turn @ turn)
    return rotation


def _quaternion(rotation: Floats) -> tuple[float, Floats]:
    """Scalar and vector part of a rotation matrix's unit quaternion, of either sign.

    The largest of the four components is found first and the others are divided by it, so that
    no angle, near pi least of all, costs accuracy (Shepperd 1978).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    squares = (xx + yy + zz, xx - yy - zz, yy - xx - zz, zz - xx - yy)
    largest = squares.index(max(squares))
    products = (
        (1 + squares[0], zy - yz, xz - zx, yx - xy),
        (zy - yz, 1 + squares[1], xy + yx, xz + zx),
        (xz - zx, xy + yx, 1 + squares[2], yz + zy),
        (yx - xy, xz + zx, yz + zy, 1 + squares[3]),
    )[largest]
    w, x, y, z = products
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    return w / norm, np.array((x, y, z)) / norm


def log(rotation: Floats) -> Floats:
    """The rotation vector of a rotation matrix, SO(3) logarithm.

    Args:
        rotation: shape (3, 3).

    Returns:
        Axis times angle, rad, shape (3,), with an angle of at most pi.
    """
    scalar, vector = _quaternion(rotation)
    if scalar < 0:
        scalar, vector = -scalar, -vector
    sine = math.hypot(*vector.tolist())
    half_angle_per_sine = math.atan2(sine, scalar) / sine if sine else 1.0
    return vector * (2.0 * half_angle_per_sine)


@compiled_once
def align(axis: Floats, wanted: Floats, fallback: Floats) -> Floats:
    """The shortest rotation that turns one unit vector onto another.

    Args:
        axis: the direction to turn, shape (3,).
        wanted: where it shall point, shape (3,).
        fallback: a unit vector at right angles to ``axis`` to turn about where every such axis
            is as short, that is, where ``wanted`` is opposite.

    Returns:
        A rotation vector at right angles to ``axis``, rad, shape (3,).
    """
    cosine = axis[0] * wanted[0] + axis[1] * wanted[1] + axis[2] * wanted[2]
    # The nearer of the two sums is exact, so the product keeps its digits near 0 and pi.
    near = wanted + axis if cosine < 0 else wanted - axis
    turn = np.empty(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turn[i] = axis[j] * near[k] - axis[k] * near[j]
    sine = math.hypot(math.hypot(turn[0], turn[1]), turn[2])
    if sine == 0.0:
        return fallback * (math.pi if cosine < 0 else 0.0)
    return turn * (math.atan2(sine, cosine) / sine)
